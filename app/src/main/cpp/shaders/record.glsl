// What the draw needs of one splat, 32 bytes: centre 2 × f32, factor 3 × f32, opacity f32, colour
// 3 × f16, 16 bits unused. The factor and the opacity keep all their bits because α depends on
// them exponentially; halves would cost up to 1e-2 of α on a needle.
struct Record {
  vec2 centre;  // px
  vec3 factor;  // Footprint
  float opacity;
  vec3 color;
};

void pack_record(Record r, out uvec4 first, out uvec4 second) {
  first = floatBitsToUint(vec4(r.centre, r.factor.xy));
  second = uvec4(floatBitsToUint(r.factor.z), floatBitsToUint(r.opacity),
                 packHalf2x16(r.color.rg), packHalf2x16(vec2(r.color.b, 0.0)));
}

Record unpack_record(uvec4 first, uvec4 second) {
  vec4 head = uintBitsToFloat(first);
  vec2 tail = uintBitsToFloat(second.xy);
  return Record(head.xy, vec3(head.zw, tail.x), tail.y,
                vec3(unpackHalf2x16(second.z), unpackHalf2x16(second.w).x));
}
