#version 310 es
// Turns the sorter's count into the draw: BATCH quads per instance, the last instance's spare
// quads being the empty projected splat behind the last splat's. Keeps the count on the GPU.
precision highp int;
precision highp float;

#include "frame.glsl"

layout(local_size_x = 128) in;

layout(std430, binding = 0) restrict readonly buffer State { uint drawn; };
layout(std430, binding = 1) restrict writeonly buffer Order { uint order[]; };
layout(std430, binding = 2) restrict writeonly buffer Arguments {  // DrawElementsIndirectCommand
  uint index_count, instance_count, first_index;
  int base_vertex;
  uint reserved;
  uint groups[3];  // DispatchIndirectCommand of gather.comp
};

void main() {
  uint batch = uint(BATCH);
  uint instances = (drawn + batch - 1u) / batch;
  uint spare = drawn + gl_LocalInvocationIndex;
  if (spare < instances * batch) order[spare] = frame.splat_count;
  if (gl_LocalInvocationIndex == 0u) {
    index_count = batch * 6u;
    instance_count = instances;
    first_index = 0u;
    base_vertex = 0;
    reserved = 0u;
    groups[0] = max((instances * batch + 127u) / 128u, 1u);  // none is a case of its own to drivers
    groups[1] = 1u;
    groups[2] = 1u;
  }
}
