#version 310 es
// project.comp where the driver has no compute shaders: a fragment is a splat, its number that of the
// texel. Writes no sort keys: such drivers get their order from the CPU.
precision highp float;
precision highp int;

layout(location = 0) out highp uvec4 first_words;
#ifndef PROJECTED_SPLAT_HALF
layout(location = 1) out highp uvec4 second_words;
#endif

#include "project_texels.glsl"

void main() { project_or_hide(uint(gl_FragCoord.y) * TEXELS_A_ROW + uint(gl_FragCoord.x)); }
