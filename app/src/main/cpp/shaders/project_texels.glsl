// The projection of a splat into two words of texels, for project.frag and project_point.vert. Those
// declare, before this file, the outputs first_words and second_words (not with PROJECTED_SPLAT_HALF).
#include "frame.glsl"
#include "projected_splat.glsl"
#include "texel_array.glsl"

uniform highp usampler2D geometry;
uniform highp usampler2D coefficients;

uvec4 geometry_at(uint i) { return texelFetch(geometry, texel_of(i), 0); }
uvec2 sh_word(uint i) { return texelFetch(coefficients, texel_of(i), 0).xy; }

void store(uint splat, uvec4 words[PROJECTED_SPLAT_SIZE]) {
  first_words = words[0];
#ifndef PROJECTED_SPLAT_HALF
  second_words = words[1];
#endif
}

void hide(uint splat) {
  first_words = uvec4(0u);
#ifndef PROJECTED_SPLAT_HALF
  second_words = uvec4(0u, floatBitsToUint(NO_LEVEL), 0u, 0u);
#endif
}

#include "project.glsl"

void project_or_hide(uint splat) {
  if (splat < frame.splat_count) {
    project(splat);
  } else {
    hide(splat);  // The empty one that fills up the last instance, and the rest of its row
  }
}
