// Shared by the steps of the radix sort (sort/gpu_radix_sorter.h explains the whole).
// RADIX_BITS: 4…8. Set by the program: FIRST_PASS (the source is the plain list of keys, and the
// dropped ones are left out), LAST_PASS (only the indices are wanted, in reverse).
//
// 128 threads are what every ES 3.1 driver offers; more would also not leave room in the shared
// memory for as many waves (sort_scatter.comp).
const uint THREADS = 128u;
const uint KEYS_PER_THREAD = 16u;
const uint BLOCK = THREADS * KEYS_PER_THREAD;
const uint RADIX = 1u << uint(RADIX_BITS);
const uint DROPPED = 0xFFFFFFFFu;

layout(local_size_x = 128) in;

// barrier() orders accesses to shared memory, too (GLSL ES 3.20, 8.15, as clarified; SPIRV-Cross issue
// 1230). `restrict` tells that no buffer is another: loads can then begin before stores (a third of
// the scatter's stalls are left on Adreno).

layout(location = 0) uniform uint shift;      // of the digit
layout(location = 1) uniform uint key_count;  // FIRST_PASS: how many keys there are

layout(std430, binding = 0) restrict buffer State {
  uint count;          // keys that were not dropped
  uint blocks[3];      // arguments of the indirect dispatch over them
  uint totals[RADIX];  // how often each digit occurs
  uint counts[];       // [block][digit]: how often in that block; after the scan, in those before
} state;

uint source_count() {
#ifdef FIRST_PASS
  return key_count;
#else
  return state.count;
#endif
}

uint block_count() { return (source_count() + BLOCK - 1u) / BLOCK; }

uint digit_of(uint key) { return (key >> shift) & (RADIX - 1u); }
