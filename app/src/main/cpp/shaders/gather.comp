#version 310 es
// Copies the projected splats into a texture in the order in which they are drawn: one thread an
// entry of the order, the ones that fill up the last instance included.
precision highp float;
precision highp int;

#include "frame.glsl"
#include "projected_splat.glsl"
#include "texel_array.glsl"

layout(local_size_x = 128) in;

layout(std430, binding = 0) restrict readonly buffer State { uint drawn; };
layout(std430, binding = 1) restrict readonly buffer Order { uint order[]; };
layout(std430, binding = 2) restrict readonly buffer ProjectedSplats { uvec4 projected_splats[]; };
layout(rgba32ui, binding = 0) restrict writeonly uniform highp uimage2D ordered;

void main() {
  uint place = gl_GlobalInvocationID.x, batch = uint(BATCH);
  if (place >= (drawn + batch - 1u) / batch * batch) return;
  uint splat = order[place];
  for (uint k = 0u; k < PROJECTED_SPLAT_SIZE; ++k)
    imageStore(ordered, texel_of(PROJECTED_SPLAT_SIZE * place + k),
               projected_splats[PROJECTED_SPLAT_SIZE * splat + k]);
}
