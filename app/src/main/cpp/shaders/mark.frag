#version 310 es
#extension GL_EXT_shader_framebuffer_fetch : require
// Where layers were blended front to back, with their transmittance in A. A tiler reads the pixel in
// the tile's memory.
// MARK: leaves the depth of its triangle, the nearest, where what lies behind can hardly be seen.
// Otherwise: puts the background behind the layers, and leaves 1 - T in A.
precision highp float;

layout(location = 0) inout highp vec4 blended;

#ifdef MARK
const float FINISHED = 1.0 / 510.0;  // half a step of 8 bits

void main() {
  if (blended.a >= FINISHED) discard;
}
#else
uniform vec3 background;

void main() { blended = vec4(blended.rgb + blended.a * background, 1.0 - blended.a); }
#endif
