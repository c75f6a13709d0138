#version 310 es
// project.frag in the vertex stage: a point is a splat, its place the texel that takes it. For drivers
// whose fragments compute with less than 32 bits, which vertices may not (GLSL ES 3.00, section 4.5.3).
precision highp float;
precision highp int;

#include "frame.glsl"
#include "projected_splat.glsl"
#include "texel_array.glsl"

uniform highp usampler2D geometry;
uniform highp usampler2D coefficients;
uniform highp float rows;  // of the texel array

flat out highp uvec4 first_words;
#ifndef PROJECTED_SPLAT_HALF
flat out highp uvec4 second_words;
#endif

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

void main() {
  uint splat = uint(gl_VertexID);
  if (splat < frame.splat_count) {
    project(splat);
  } else {
    hide(splat);  // The empty one that fills up the last instance
  }
  vec2 texel = vec2(texel_of(splat)) + 0.5;
  gl_Position = vec4(2.0 * texel / vec2(float(TEXELS_A_ROW), rows) - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}
