#version 310 es
// project.comp where the driver has no compute shaders: a fragment is a splat, its number that of the
// texel. Writes no sort keys: such drivers get their order from the CPU.
precision highp float;
precision highp int;

#include "frame.glsl"
#include "projected_splat.glsl"
#include "texel_array.glsl"

uniform highp usampler2D geometry;
uniform highp usampler2D coefficients;

layout(location = 0) out highp uvec4 out_first;
#ifndef PROJECTED_SPLAT_HALF
layout(location = 1) out highp uvec4 out_second;
#endif

uvec4 geometry_at(uint i) { return texelFetch(geometry, texel_of(i), 0); }
uvec2 sh_word(uint i) { return texelFetch(coefficients, texel_of(i), 0).xy; }

void store(uint splat, uvec4 words[PROJECTED_SPLAT_SIZE]) {
  out_first = words[0];
#ifndef PROJECTED_SPLAT_HALF
  out_second = words[1];
#endif
}

void hide(uint splat) {
  out_first = uvec4(0u);
#ifndef PROJECTED_SPLAT_HALF
  out_second = uvec4(0u, floatBitsToUint(NO_LEVEL), 0u, 0u);
#endif
}

#include "project.glsl"

void main() {
  uint splat = uint(gl_FragCoord.y) * TEXELS_A_ROW + uint(gl_FragCoord.x);
  if (splat < frame.splat_count) {
    project(splat);
  } else {
    hide(splat);  // The empty one that fills up the last instance, and the rest of its row
  }
}
