#version 310 es
// One corner of the quad that covers a splat down to the cut-off. A tiler runs this again for every
// bin, so all that is heavy is in project.comp.
precision highp float;
precision highp int;

#include "frame.glsl"
#include "projected_splat.glsl"
#include "texel_array.glsl"

#ifdef TEXTURE_FETCH
// For drivers without storage buffers in the vertex stage: the splats in drawing order.
uniform highp usampler2D ordered;
uint splat_at(uint place) { return place; }
uvec4 part_of_splat(uint splat, uint k) { return texelFetch(ordered, texel_of(PROJECTED_SPLAT_SIZE * splat + k), 0); }
#elif defined(PROJECTED_BY_FRAGMENTS)
// For drivers without compute shaders: what project.frag wrote, and the order of the CPU.
uniform highp usampler2D order;
uniform highp uint drawn;  // entries of the order; the splat behind the last is the empty one
uniform highp usampler2D first_words;
uint splat_at(uint place) { return place < drawn ? texelFetch(order, texel_of(place), 0).x : frame.splat_count; }
#ifdef PROJECTED_SPLAT_HALF
uvec4 part_of_splat(uint splat, uint k) { return texelFetch(first_words, texel_of(splat), 0); }
#else
uniform highp usampler2D second_words;
uvec4 part_of_splat(uint splat, uint k) {
  return k == 0u ? texelFetch(first_words, texel_of(splat), 0) : texelFetch(second_words, texel_of(splat), 0);
}
#endif
#else
layout(std430, binding = 0) restrict readonly buffer ProjectedSplats { uvec4 projected_splats[]; };
layout(std430, binding = 1) restrict readonly buffer Order { uint order[]; };
uint splat_at(uint place) { return order[place]; }
uvec4 part_of_splat(uint splat, uint k) { return projected_splats[PROJECTED_SPLAT_SIZE * splat + k]; }
#endif

#ifdef FRONT_TO_BACK
layout(std430, binding = 2) restrict readonly buffer State { uint drawn; };
uniform uint slice;  // of how many in a frame
uniform uint slices;

// The order is back to front, with spare entries behind its end.
uint place_of(uint quad) {
  uint batch = uint(BATCH);
  uint instances = (drawn + batch - 1u) / batch;
  uint place = slice * ((instances + slices - 1u) / slices) * batch + quad;
  return place < drawn ? drawn - 1u - place : place;
}
#else
uint place_of(uint quad) { return quad; }
#endif

// u = shape.x·x + shape.y·y + offset.x, v = shape.z·y + offset.y at the pixel (x, y)
flat out highp vec2 v_offset;
flat out highp vec4 v_shape;  // xx, xy, yy, level
flat out highp vec3 v_color;

const float PAD = 0.0625;    // px: corners may be moved to a grid as coarse as 1/16 px
const float LARGE = 4096.0;  // px: beyond this a quad's interpolation loses the image

ProjectedSplat read_projected_splat(uint splat) {
  uvec4 words[PROJECTED_SPLAT_SIZE];
  for (uint k = 0u; k < PROJECTED_SPLAT_SIZE; ++k) words[k] = part_of_splat(splat, k);
  return unpack_projected_splat(words);
}

void main() {
  ProjectedSplat r = read_projected_splat(splat_at(place_of(uint(gl_InstanceID) * uint(BATCH) + uint(gl_VertexID >> 2))));
  v_offset = -vec2(r.factor.x * r.centre.x + r.factor.y * r.centre.y, r.factor.z * r.centre.y);
  v_shape = vec4(r.factor, r.level);
  v_color = r.color;

  // The square |u|, |v| ≤ radius, taken to the screen by the factor's inverse: a parallelogram as
  // large as the rectangle along the ellipse's axes, found without an eigendecomposition.
  vec2 corner = vec2(float(gl_VertexID & 1), float((gl_VertexID >> 1) & 1)) * 2.0 - 1.0;
  float radius = min(sqrt(max(r.level - frame.level_min, 0.0)), frame.radius_max);
  vec2 reach = vec2(radius + PAD * (r.factor.x + abs(r.factor.y)), radius + PAD * r.factor.z);
  vec2 uv = corner * reach;
  float dy = uv.y / r.factor.z;
  vec2 pixel = r.centre + vec2((uv.x - r.factor.y * dy) / r.factor.x, dy);

  vec2 extent = vec2(reach.x + abs(r.factor.y / r.factor.z) * reach.y, reach.y) /
                vec2(r.factor.x, r.factor.z);
  if (max(extent.x, extent.y) > LARGE) {
    pixel = clamp(r.centre + corner * extent, vec2(0.0), frame.target_size);
  }
  // Row 0 of the target's memory is the top of the image: no flip here, none when reading.
  vec2 position = pixel / frame.target_size * 2.0 - 1.0;
  // What is not to be drawn has its four corners at one point outside.
  gl_Position = r.level < frame.level_min ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(position, 0.0, 1.0);
}
