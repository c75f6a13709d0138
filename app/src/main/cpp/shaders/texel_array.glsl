// Arrays in textures (gl/texel_array.h): entry i is a texel.
const uint TEXELS_A_ROW = 2048u;
ivec2 texel_of(uint i) { return ivec2(i % TEXELS_A_ROW, i / TEXELS_A_ROW); }
