#version 310 es
// Sort, step 2 of 3: turns the counts per block and digit into the counts in all the blocks before,
// and adds up each digit's total. A work group takes 16 digits; 8 threads share a digit, each with
// a run of blocks of its own.
precision highp int;

#include "sort.glsl"

const uint DIGITS = 16u;
const uint RUNS = THREADS / DIGITS;

shared uint sums[RUNS * DIGITS];

void main() {
  uint run = gl_LocalInvocationIndex / DIGITS, column = gl_LocalInvocationIndex % DIGITS;
  uint digit = gl_WorkGroupID.x * DIGITS + column;
  uint blocks = block_count(), length = (blocks + RUNS - 1u) / RUNS;
  uint first = min(run * length, blocks), end = min(first + length, blocks);

  uint sum = 0u;
  for (uint block = first; block < end; ++block) sum += state.counts[block * RADIX + digit];
  sums[gl_LocalInvocationIndex] = sum;
  barrier();
  uint before = 0u;
  for (uint r = 0u; r < run; ++r) before += sums[r * DIGITS + column];
  if (run == RUNS - 1u) state.totals[digit] = before + sum;
  for (uint block = first; block < end; ++block) {
    uint own = state.counts[block * RADIX + digit];
    state.counts[block * RADIX + digit] = before;
    before += own;
  }
}
