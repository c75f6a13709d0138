#version 310 es
// Copies the accumulated picture to the target, whose format limits and rounds it.
precision highp float;

layout(binding = 0) uniform highp sampler2D accumulated;
layout(location = 0) out highp vec4 out_color;

void main() { out_color = texelFetch(accumulated, ivec2(gl_FragCoord.xy), 0); }
