// A pass of the radix sort over 8 bits of the keys: count, scan, scatter. The twin of shaders/sort.glsl and of
// the three steps' files, which explain it (sort/gpu_radix_sorter.h the whole), but for the first pass: here it
// reads pairs as the others do, and drops what `arguments` then no longer counts.
@group(0) @binding(0) var<uniform> shift: vec4u;  // x: of the digit
@group(0) @binding(1) var<storage, read_write> state: State;
@group(0) @binding(2) var<storage, read> source: array<vec2u>;       // (key, number)
@group(0) @binding(3) var<storage, read_write> sorted: array<u32>;   // such pairs; in the last pass numbers

override last = false;  // writes numbers only, in reverse

const THREADS = 128u;
const KEYS_PER_THREAD = 16u;
const RADIX = 256u;
const WORDS = THREADS / 32u;
const DIGITS = 16u;  // of a work group of the scan
const RUNS = THREADS / DIGITS;

fn digit_of(key: u32) -> u32 { return (key >> shift.x) & (RADIX - 1u); }
fn block_count() -> u32 { return (state.count + BLOCK - 1u) / BLOCK; }
fn key_at(i: u32) -> u32 {
  if (i < state.count) { return source[i].x; }
  return DROPPED;
}

var<workgroup> histogram: array<atomic<u32>, RADIX>;

@compute @workgroup_size(THREADS)
fn count(@builtin(local_invocation_index) thread: u32, @builtin(workgroup_id) group: vec3u) {
  for (var d = thread; d < RADIX; d += THREADS) { atomicStore(&histogram[d], 0u); }
  workgroupBarrier();
  for (var k = 0u; k < KEYS_PER_THREAD; k++) {
    let key = key_at(group.x * BLOCK + k * THREADS + thread);
    if (key != DROPPED) { atomicAdd(&histogram[digit_of(key)], 1u); }
  }
  workgroupBarrier();
  for (var d = thread; d < RADIX; d += THREADS) { state.counts[group.x * RADIX + d] = atomicLoad(&histogram[d]); }
}

var<workgroup> sums: array<u32, THREADS>;

@compute @workgroup_size(THREADS)
fn scan(@builtin(local_invocation_index) thread: u32, @builtin(workgroup_id) group: vec3u) {
  let run = thread / DIGITS;
  let column = thread % DIGITS;
  let digit = group.x * DIGITS + column;
  let blocks = block_count();
  let length = (blocks + RUNS - 1u) / RUNS;
  let first = min(run * length, blocks);
  let end = min(first + length, blocks);

  var sum = 0u;
  for (var block = first; block < end; block++) { sum += state.counts[block * RADIX + digit]; }
  sums[thread] = sum;
  workgroupBarrier();
  var before = 0u;
  for (var r = 0u; r < run; r++) { before += sums[r * DIGITS + column]; }
  if (run == RUNS - 1u) { state.totals[digit] = before + sum; }
  for (var block = first; block < end; block++) {
    let own = state.counts[block * RADIX + digit];
    state.counts[block * RADIX + digit] = before;
    before += own;
  }
}

var<workgroup> masks: array<atomic<u32>, WORDS * RADIX>;  // [word][digit]
var<workgroup> next: array<u32, RADIX>;                   // where the next key of each digit goes

fn find_starts(thread: u32, block: u32) {
  for (var d = thread; d < RADIX; d += THREADS) { atomicStore(&masks[d], state.totals[d]); }
  workgroupBarrier();
  if (thread < RADIX / 16u) {
    var sum = 0u;
    for (var d = 0u; d < 16u; d++) { sum += atomicLoad(&masks[thread * 16u + d]); }
    atomicStore(&masks[RADIX + thread], sum);
  }
  workgroupBarrier();
  var total = 0u;
  for (var g = 0u; g < RADIX / 16u; g++) { total += atomicLoad(&masks[RADIX + g]); }
  for (var digit = thread; digit < RADIX; digit += THREADS) {
    var start = state.counts[block * RADIX + digit];
    for (var g = 0u; g < digit / 16u; g++) { start += atomicLoad(&masks[RADIX + g]); }
    for (var d = digit & ~15u; d < digit; d++) { start += atomicLoad(&masks[d]); }
    next[digit] = select(start, total - 1u - start, last);
  }
  workgroupBarrier();
  for (var i = thread; i < WORDS * RADIX; i += THREADS) { atomicStore(&masks[i], 0u); }
  workgroupBarrier();
}

@compute @workgroup_size(THREADS)
fn scatter(@builtin(local_invocation_index) thread: u32, @builtin(workgroup_id) group: vec3u) {
  let word = thread >> 5u;
  let bit = 1u << (thread & 31u);
  find_starts(thread, group.x);

  for (var k = 0u; k < KEYS_PER_THREAD; k++) {
    let i = group.x * BLOCK + k * THREADS + thread;
    let key = key_at(i);
    let digit = digit_of(key);
    let valid = key != DROPPED;
    if (valid) { atomicOr(&masks[word * RADIX + digit], bit); }
    workgroupBarrier();
    var rank = 0u;
    var same = 0u;
    if (valid) {
      for (var w = 0u; w < WORDS; w++) {
        let mask = atomicLoad(&masks[w * RADIX + digit]);
        same += countOneBits(mask);
        rank += select(0u, countOneBits(select(mask, mask & (bit - 1u), w == word)), w <= word);
      }
      if (last) {
        sorted[next[digit] - rank] = source[i].y;
      } else {
        let at = 2u * (next[digit] + rank);
        sorted[at] = key;
        sorted[at + 1u] = source[i].y;
      }
    }
    workgroupBarrier();
    if (valid) {
      atomicStore(&masks[word * RADIX + digit], 0u);
      if (rank + 1u == same) {  // The last of its digit moves it on
        next[digit] = select(next[digit] + same, next[digit] - same, last);
      }
    }
    workgroupBarrier();
  }
}
