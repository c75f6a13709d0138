#version 310 es
// Culls and projects: one thread reads one splat, writes its sort key and, where it can touch the
// picture, the record that the draw reads.
precision highp float;
precision highp int;

#include "frame.glsl"
#include "record.glsl"

layout(local_size_x = 256) in;

// Per splat: (position relative to the scene's origin, opacity), (scale, red), (rotation xyzw),
// (green, blue, 0, 0). Red, green and blue are the constant term of the colour.
layout(std430, binding = 0) readonly buffer Geometry { vec4 geometry[]; };
layout(std430, binding = 1) readonly buffer Harmonics { vec4 coefficients[]; };
layout(std430, binding = 2) writeonly buffer Records { uvec4 records[]; };
layout(std430, binding = 3) writeonly buffer Keys { uint keys[]; };

// The vec4s of `coefficients` per splat.
layout(location = 0) uniform uint harmonics_stride;

#include "projection.glsl"
#include "spherical_harmonics.glsl"

const uint CULLED = 0xFFFFFFFFu;   // Sorter::kDropped
const float MAX_COLOR = 60000.0;   // below the largest half float

bool touches_picture(vec2 centre, vec2 half_extent) {
  return all(greaterThan(centre + half_extent, vec2(0.0))) &&
         all(lessThan(centre - half_extent, frame.target_size));
}

// Returns the key: the depth's bits, which are ordered like the depth itself as it is positive.
uint project(uint splat) {
  vec4 centre_opacity = geometry[4u * splat];
  float opacity = centre_opacity.w;
  vec3 ray = centre_opacity.xyz - frame.camera_centre.xyz;
  vec3 p = vec3(dot(frame.rotation_row0.xyz, ray), dot(frame.rotation_row1.xyz, ray),
                dot(frame.rotation_row2.xyz, ray));
  if (!(p.z > frame.near_plane) || !(opacity >= frame.alpha_min)) return CULLED;

  vec4 scale_red = geometry[4u * splat + 1u];
  vec3 axes_x, axes_y;
  screen_axes(p, geometry[4u * splat + 2u], scale_red.xyz, axes_x, axes_y);
  Footprint shape = footprint(axes_x, axes_y);
  vec2 centre = frame.focal_centre.xy * (p.xy / p.z) + frame.focal_centre.zw;
  // Where α falls below alpha_min, not at a fixed number of deviations.
  float radius = sqrt(2.0 * log(opacity / frame.alpha_min));
  if (!touches_picture(centre, radius * shape.deviation)) return CULLED;

  vec3 color = vec3(scale_red.w, geometry[4u * splat + 3u].xy);
  float distance2 = dot(ray, ray);
  vec3 direction = ray * (distance2 > 0.0 ? inversesqrt(distance2) : 0.0);
  color += sh_rest(splat * harmonics_stride, frame.sh_degree, direction);
  color = clamp(color, 0.0, MAX_COLOR);
  uvec4 first, second;
  pack_record(Record(centre, shape.factor, opacity, color), first, second);
  records[2u * splat] = first;
  records[2u * splat + 1u] = second;
  return floatBitsToUint(p.z);
}

void main() {
  uint splat = gl_GlobalInvocationID.x;
  if (splat < frame.splat_count) keys[splat] = project(splat);
}
