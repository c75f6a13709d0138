// After the first pass of the sort: the number of keys that it kept, the work groups of the later passes, and the
// draw: BATCH quads an instance, the last one's spare quads being the empty projected splat behind the last.
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read_write> state: State;
@group(0) @binding(2) var<storage, read_write> order: array<u32>;
@group(0) @binding(3) var<storage, read_write> commands: array<u32>;  // a dispatch, a spare word, an indexed draw

var<workgroup> total: atomic<u32>;

@compute @workgroup_size(128)
fn arguments(@builtin(local_invocation_index) thread: u32) {
  atomicAdd(&total, state.totals[thread] + state.totals[thread + 128u]);
  workgroupBarrier();
  let drawn = atomicLoad(&total);
  let instances = (drawn + BATCH - 1u) / BATCH;
  let spare = drawn + thread;
  if (spare < instances * BATCH) { order[spare] = frame.splat_count; }
  if (thread == 0u) {
    state.count = drawn;
    commands[0] = max((drawn + BLOCK - 1u) / BLOCK, 1u);
    commands[1] = 1u;
    commands[2] = 1u;
    commands[4] = BATCH * 6u;
    commands[5] = instances;
    commands[6] = 0u;
    commands[7] = 0u;
    commands[8] = 0u;
  }
}
