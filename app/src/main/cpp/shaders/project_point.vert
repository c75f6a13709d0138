#version 310 es
// project.frag in the vertex stage: a point is a splat, its place the texel that takes it. For drivers
// whose fragments compute with less than 32 bits, which vertices may not (GLSL ES 3.00, section 4.5.3).
precision highp float;
precision highp int;

uniform highp float rows;  // of the texel array

flat out highp uvec4 first_words;
#ifndef PROJECTED_SPLAT_HALF
flat out highp uvec4 second_words;
#endif

#include "project_texels.glsl"

void main() {
  uint splat = uint(gl_VertexID);
  project_or_hide(splat);
  vec2 texel = vec2(texel_of(splat)) + 0.5;
  gl_Position = vec4(2.0 * texel / vec2(float(TEXELS_A_ROW), rows) - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}
