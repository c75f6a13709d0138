// A projected splat. α = 2^(level − u² − v²) with u = xx·d.x + xy·d.y, v = yy·d.y,
// d = pixel − centre: the footprint of projection.glsl in units that save the fragment shader a
// multiplication.
struct ProjectedSplat {
  vec2 centre;  // px
  vec3 factor;  // xx, xy, yy
  float level;  // log2 of the opacity, or NO_LEVEL: not to be drawn
  vec3 color;
};

const float NO_LEVEL = -1e30;
const float TO_LEVELS = 0.84932180028802;  // √(½·log2 e): from Footprint::factor to ProjectedSplat::factor

#ifdef PROJECTED_SPLAT_HALF
// 16 bytes: centre 2 × 19 bits of 1/64 px from the image's middle, factor 3 × f16, colour 3 × 10
// bits of 0…2, opacity 9 bits. Centres beyond 4096 px are moved to there.
const uint PROJECTED_SPLAT_SIZE = 1u;  // uvec4s
const float CENTRE_STEPS = 64.0, CENTRE_LIMIT = 262143.0;
const float COLOR_STEPS = 511.5, OPACITY_STEPS = 511.0;
// Of a half float that is neither infinite nor, as drivers may take small ones, zero: a splat of
// more than 13,914 px is drawn as if it had so many.
const float LEAST_FACTOR = 6.103515625e-5, LARGEST_FACTOR = 65504.0;

void pack_projected_splat(ProjectedSplat r, out uvec4 words[PROJECTED_SPLAT_SIZE]) {
  vec2 steps = round((r.centre - 0.5 * frame.target_size) * CENTRE_STEPS);
  uvec2 centre = uvec2(ivec2(clamp(steps, -CENTRE_LIMIT, CENTRE_LIMIT))) & 0x7FFFFu;
  uvec3 color = uvec3(round(min(r.color, 2.0) * COLOR_STEPS));
  uint opacity = uint(round(exp2(r.level) * OPACITY_STEPS));
  vec3 factor = clamp(r.factor, vec3(LEAST_FACTOR, -LARGEST_FACTOR, LEAST_FACTOR),
                      vec3(LARGEST_FACTOR));
  words[0] = uvec4(centre.x | (color.r << 19) | ((opacity >> 6) << 29),
                    centre.y | (color.g << 19), packHalf2x16(factor.xy),
                    packHalf2x16(vec2(factor.z, 0.0)) | (color.b << 16) | (opacity << 26));
}

ProjectedSplat unpack_projected_splat(uvec4 words[PROJECTED_SPLAT_SIZE]) {
  uvec4 p = words[0];
  ivec2 steps = ivec2(p.xy << 13) >> 13;
  vec3 color = vec3((uvec3(p.xy >> 19, p.w >> 16)) & 0x3FFu) / COLOR_STEPS;
  float opacity = float((p.w >> 26) | ((p.x >> 29) << 6)) / OPACITY_STEPS;
  return ProjectedSplat(vec2(steps) / CENTRE_STEPS + 0.5 * frame.target_size,
                vec3(unpackHalf2x16(p.z), unpackHalf2x16(p.w & 0xFFFFu).x),
                opacity > 0.0 ? log2(opacity) : NO_LEVEL, color);
}
#else
// 32 bytes: centre 2 × f32, factor 3 × f32, level f32, colour 3 × f16, 16 bits unused. Factor and
// level keep all their bits because α depends on them exponentially; halves would cost up to 1e-2
// of α on a needle.
const uint PROJECTED_SPLAT_SIZE = 2u;  // uvec4s

void pack_projected_splat(ProjectedSplat r, out uvec4 words[PROJECTED_SPLAT_SIZE]) {
  words[0] = floatBitsToUint(vec4(r.centre, r.factor.xy));
  words[1] = uvec4(floatBitsToUint(r.factor.z), floatBitsToUint(r.level),
                    packHalf2x16(r.color.rg), packHalf2x16(vec2(r.color.b, 0.0)));
}

ProjectedSplat unpack_projected_splat(uvec4 words[PROJECTED_SPLAT_SIZE]) {
  vec4 head = uintBitsToFloat(words[0]);
  vec2 tail = uintBitsToFloat(words[1].xy);
  return ProjectedSplat(head.xy, vec3(head.zw, tail.x), tail.y,
                vec3(unpackHalf2x16(words[1].z), unpackHalf2x16(words[1].w).x));
}
#endif
