#version 310 es
// Sort, step 1 of 3: how often each digit occurs in each block of keys.
precision highp int;

#include "sort.glsl"
#include "sort_source.glsl"

shared uint histogram[RADIX];

void main() {
  uint thread = gl_LocalInvocationIndex, block = gl_WorkGroupID.x;
  for (uint d = thread; d < RADIX; d += THREADS) histogram[d] = 0u;
  barrier();
  for (uint k = 0u; k < KEYS_PER_THREAD; ++k) {
    uint key = source_key(block * BLOCK + k * THREADS + thread);
    if (key != DROPPED) atomicAdd(histogram[digit_of(key)], 1u);
  }
  barrier();
  for (uint d = thread; d < RADIX; d += THREADS) state.counts[block * RADIX + d] = histogram[d];
}
