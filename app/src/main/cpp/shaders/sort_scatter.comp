#version 310 es
// Sort, step 3 of 3: every key goes to its place: behind the smaller digits, behind its own digit
// in the blocks before, behind its own digit earlier in the block. That keeps equal keys in order.
// Within a block the rank comes from bit masks: 128 keys at a time set their bit in the mask of
// their digit, and a key's rank is the number of bits below its own.
//
// 8-bit digits take 5 KB of shared memory; with 9 KB (256 threads) an Adreno 750 runs 6 waves at a
// time instead of 12.
precision highp int;

#include "sort.glsl"
#include "sort_source.glsl"

#ifdef LAST_PASS
layout(std430, binding = 2) restrict writeonly buffer Target { uint order[]; };
#else
layout(std430, binding = 2) restrict writeonly buffer Target { uvec2 pairs[]; };
#endif

const uint WORDS = THREADS / 32u;

shared uint masks[WORDS * RADIX];  // [word][digit]: neighbouring digits lie in different banks
shared uint next[RADIX];           // where the next key of each digit goes

// next[digit] = the number of keys with a smaller digit, plus those in the blocks before; in the
// last pass, which reverses the order, the same counted from the end.
// Returns the number of all keys. The masks, not yet in use, hold the totals and their sums by 16;
// they are left empty.
uint find_starts(uint thread, uint block) {
  const uint GROUPS = RADIX / 16u;
  for (uint d = thread; d < RADIX; d += THREADS) masks[d] = state.totals[d];
  barrier();
  if (thread < GROUPS) {
    uint sum = 0u;
    for (uint d = 0u; d < 16u; ++d) sum += masks[thread * 16u + d];
    masks[RADIX + thread] = sum;
  }
  barrier();
  uint total = 0u;
  for (uint g = 0u; g < GROUPS; ++g) total += masks[RADIX + g];
  for (uint digit = thread; digit < RADIX; digit += THREADS) {
    uint start = state.counts[block * RADIX + digit];
    for (uint g = 0u; g < digit / 16u; ++g) start += masks[RADIX + g];
    for (uint d = digit & ~15u; d < digit; ++d) start += masks[d];
#ifdef LAST_PASS
    next[digit] = total - 1u - start;
#else
    next[digit] = start;
#endif
  }
  barrier();
  for (uint i = thread; i < WORDS * RADIX; i += THREADS) masks[i] = 0u;
  barrier();
  return total;
}

void put(uint key, uint digit, uint rank, uint i) {
#ifdef FIRST_PASS
  uint index = i;
#else
  uint index = source_pairs[i].y;
#endif
#ifdef LAST_PASS
  order[next[digit] - rank] = index;
#else
  pairs[next[digit] + rank] = uvec2(key, index);
#endif
}

void advance(uint digit, uint by) {
#ifdef LAST_PASS
  next[digit] -= by;
#else
  next[digit] += by;
#endif
}

void main() {
  uint thread = gl_LocalInvocationIndex, block = gl_WorkGroupID.x;
  uint word = thread >> 5u, bit = 1u << (thread & 31u);
  uint total = find_starts(thread, block);

  for (uint k = 0u; k < KEYS_PER_THREAD; ++k) {
    uint i = block * BLOCK + k * THREADS + thread;
    uint key = source_key(i), digit = digit_of(key);
    bool valid = key != DROPPED;
    if (valid) atomicOr(masks[word * RADIX + digit], bit);
    barrier();
    uint rank = 0u, same = 0u;
    if (valid) {
      for (uint w = 0u; w < WORDS; ++w) {
        uint mask = masks[w * RADIX + digit];
        same += uint(bitCount(mask));
        if (w == word) mask &= bit - 1u;
        if (w <= word) rank += uint(bitCount(mask));
      }
      put(key, digit, rank, i);
    }
    barrier();
    if (valid) {
      masks[word * RADIX + digit] = 0u;
      if (rank + 1u == same) advance(digit, same);  // The last of its digit moves it on
    }
    barrier();
  }

#ifdef FIRST_PASS
  if (block == 0u && thread == 0u) {  // The passes that follow see only what was not dropped
    state.count = total;
    state.blocks[0] = max((total + BLOCK - 1u) / BLOCK, 1u);
    state.blocks[1] = 1u;
    state.blocks[2] = 1u;
  }
#endif
}
