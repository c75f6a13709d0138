#version 310 es
// Culls and projects: one thread reads one splat, writes its sort key and, where it can touch the
// image, what the draw reads. Variants: PROJECTED_SPLAT_HALF, and COMPENSATED for a screen filter that
// compensates opacities.
precision highp float;
precision highp int;

#include "frame.glsl"
#include "projected_splat.glsl"

layout(local_size_x = 128) in;

// `restrict`: Adreno's compiler reads through its cache only what it knows that nobody writes.
layout(std430, binding = 0) restrict readonly buffer Geometry { uvec4 geometry[]; };
layout(std430, binding = 1) restrict readonly buffer Sh { uvec2 coefficients[]; };  // half floats
layout(std430, binding = 2) restrict writeonly buffer ProjectedSplats { uvec4 projected_splats[]; };
layout(std430, binding = 3) restrict writeonly buffer Keys { uint keys[]; };

uvec4 geometry_at(uint i) { return geometry[i]; }
uvec2 sh_word(uint i) { return coefficients[i]; }

// An order that was made for another view names splats that this one culls.
void hide(uint splat) {
#ifdef PROJECTED_SPLAT_HALF
  projected_splats[splat] = uvec4(0u);
#else
  projected_splats[2u * splat + 1u].y = floatBitsToUint(NO_LEVEL);
#endif
}

void store(uint splat, uvec4 words[PROJECTED_SPLAT_SIZE]) {
  for (uint k = 0u; k < PROJECTED_SPLAT_SIZE; ++k) projected_splats[PROJECTED_SPLAT_SIZE * splat + k] = words[k];
}

#include "project.glsl"

void main() {
  uint splat = gl_GlobalInvocationID.x;
  if (splat < frame.splat_count) keys[splat] = project(splat);
  if (splat == frame.splat_count) hide(splat);  // The empty one that fills up the last instance
}
