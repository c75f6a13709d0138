// Source of the keys of a sorting pass.
#ifdef FIRST_PASS
layout(std430, binding = 1) restrict readonly buffer Source { uint source_keys[]; };
uint source_key(uint i) { return i < key_count ? source_keys[i] : DROPPED; }
#else
layout(std430, binding = 1) restrict readonly buffer Source { uvec2 source_pairs[]; };  // (key, index)
uint source_key(uint i) { return i < state.count ? source_pairs[i].x : DROPPED; }
#endif
