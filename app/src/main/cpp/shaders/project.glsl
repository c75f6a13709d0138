// Culls and projects a splat, for project.comp and project_texels.glsl. Those give it, before this file:
//   uvec4 geometry_at(uint i), uvec2 sh_word(uint i): the scene (PackedSplats in render/scene_packing.h)
//   void store(uint splat, uvec4 words[PROJECTED_SPLAT_SIZE]): takes what the draw reads
//   void hide(uint splat): takes that it is not drawn
//
// Per splat four words of the geometry: (position relative to the scene's origin, log2 of the opacity),
// (scale, red), (rotation xyzw), (green, blue, 0, SH coefficients). Red, green and blue are the constant
// term of the colour. All are floats but the last: 4·(the first of its words of coefficients) + its
// degree, which as a float would be a denormal that drivers may take for zero.

#include "projection.glsl"
#include "spherical_harmonics.glsl"

const uint CULLED = 0xFFFFFFFFu;   // Sorter::kDropped
const float MAX_COLOR = 60000.0;   // below the largest half float

bool touches_image(vec2 centre, vec2 half_extent) {
  return all(greaterThan(centre + half_extent, vec2(0.0))) &&
         all(lessThan(centre - half_extent, frame.target_size));
}

// sort/depth_keys.h. The bits of positive floats are ordered like the floats.
uint depth_key(float depth) {
  uint bits = floatBitsToUint(depth);
  return min((max(bits, frame.key_low) - frame.key_low) >> frame.key_shift, frame.key_max);
}

// Each splat's degree is its own. Where neighbours have the same, so do the threads of a group, and
// none waits for another; files keep the splats of a degree together.
vec3 color_of(uvec4 words, float red, vec3 ray) {
  vec3 color = vec3(red, uintBitsToFloat(words.xy));
  float distance2 = dot(ray, ray);
  vec3 direction = ray * (distance2 > 0.0 ? inversesqrt(distance2) : 0.0);
  color += sh_rest(words.w >> 2, min(words.w & 3u, frame.sh_degree), direction);
  return clamp(color, 0.0, MAX_COLOR);
}

// Returns the key.
uint project(uint splat) {
  vec4 centre_level = uintBitsToFloat(geometry_at(4u * splat));
  float level = centre_level.w;
  vec3 ray = centre_level.xyz - frame.camera_centre.xyz;
  vec3 p = vec3(dot(frame.rotation_row0.xyz, ray), dot(frame.rotation_row1.xyz, ray),
                dot(frame.rotation_row2.xyz, ray));
  if (!(p.z > frame.near_plane) || !(level >= frame.level_min)) {
    hide(splat);
    return CULLED;
  }
  // Early, for the coefficients wait for it
  uvec4 green_blue_sh = geometry_at(4u * splat + 3u);
  vec4 scale_red = uintBitsToFloat(geometry_at(4u * splat + 1u));
  vec3 axes_x, axes_y;
  vec4 rotation = uintBitsToFloat(geometry_at(4u * splat + 2u));
  screen_axes(p, rotation, scale_red.xyz, axes_x, axes_y);
  Footprint shape = footprint(axes_x, axes_y);
#ifdef COMPENSATED
  level += 0.5 * log2(shape.share + 1e-30);  // log2 of 0 is not defined (GLSL ES 3.1, 8.2)
  bool seen = level >= frame.level_min;
  level = max(level, frame.level_min);
#endif
  vec2 centre = frame.focal_centre.xy * (p.xy / p.z) + frame.focal_centre.zw;
  // Where α falls below the cut-off, not at a fixed number of deviations.
  float radius = min(sqrt(level - frame.level_min), frame.radius_max) / TO_LEVELS;
  vec2 half_extent = radius * shape.deviation;
  // √det Σ′ is 1/(xx·yy), which may be infinite
  bool light = exp2(level) < frame.weight_min * (shape.factor.x * shape.factor.z);
  bool drawable = !light && is_flat(p.z, rotation, scale_red.xyz);
#ifdef COMPENSATED
  drawable = drawable && seen;
#endif
  if (!drawable || !touches_image(centre, half_extent)) {
    hide(splat);
    bool near_by = drawable && touches_image(centre, half_extent + frame.sort_margin);
    return near_by ? depth_key(p.z) : CULLED;
  }
  uvec4 words[PROJECTED_SPLAT_SIZE];
  vec3 color = color_of(green_blue_sh, scale_red.w, ray);
  pack_projected_splat(ProjectedSplat(centre, shape.factor * TO_LEVELS, level, color), words);
  store(splat, words);
  return depth_key(p.z);
}
