#version 310 es
// Turns the sorter's count into the draws: BATCH quads per instance, the last instance's spare
// quads being the empty projected splat behind the last splat's. Keeps the count on the GPU.
precision highp int;
precision highp float;

#include "frame.glsl"

layout(local_size_x = 128) in;

layout(std430, binding = 0) restrict readonly buffer State { uint drawn; };
layout(std430, binding = 1) restrict writeonly buffer Order { uint order[]; };

struct DrawElementsIndirectCommand {
  uint index_count, instance_count, first_index;
  int base_vertex;
  uint reserved;
};
layout(std430, binding = 2) restrict writeonly buffer Arguments {
  uint groups[4];  // DispatchIndirectCommand of gather.comp, and a spare
  DrawElementsIndirectCommand draws[];  // as many instances each, but for the last ones
};

void main() {
  uint batch = uint(BATCH);
  uint instances = (drawn + batch - 1u) / batch;
  uint spare = drawn + gl_LocalInvocationIndex;
  if (spare < instances * batch) order[spare] = frame.splat_count;
  uint slices = uint(draws.length()), slice = gl_LocalInvocationIndex;
  if (slice < slices) {
    uint each = (instances + slices - 1u) / slices;
    uint before = min(slice * each, instances);
    draws[slice] = DrawElementsIndirectCommand(batch * 6u, min(each, instances - before), 0u, 0, 0u);
  }
  if (slice == 0u) {
    groups[0] = max((instances * batch + 127u) / 128u, 1u);  // none is a case of its own to drivers
    groups[1] = 1u;
    groups[2] = 1u;
  }
}
