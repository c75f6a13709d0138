// The texture of projected splats in drawing order: the splats' uvec4s, one behind the other.
const uint ORDERED_WIDTH = 2048u;  // render/ordered_splats.cpp
ivec2 ordered_texel(uint i) { return ivec2(i % ORDERED_WIDTH, i / ORDERED_WIDTH); }
