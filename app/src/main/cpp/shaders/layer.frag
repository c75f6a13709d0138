#version 310 es
// A faint layer, for render/blend_check.h.
precision highp float;
out vec4 out_color;
void main() { out_color = vec4(0.5, 0.5, 0.5, 0.01); }
