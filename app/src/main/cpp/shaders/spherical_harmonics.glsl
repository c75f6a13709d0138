// Real SH of degrees 1…3: the twin of fluxgs/math/spherical_harmonics.h.
// Coefficients are stored in groups of four RGB triples, three times four half floats each;
// `weights` are the four basis functions that belong to a group.

// A half float's bits moved to where a float has its own: its value times 2^-112, which the weights
// make up for. Halves below 2^-14 may count as zero. unpackHalf2x16() is a long calculation for some
// compilers.
vec4 four_coefficients(uint at) {
  uvec2 halves = sh_word(at);
  return uintBitsToFloat(uvec4(ivec4(halves.x << 16, halves.x, halves.y << 16, halves.y) >> 3) &
                         0x8FFFE000u);
}
const float K = 5.192296858534828e33;  // 2^112

vec3 sh_group(uint first, vec4 weights) {
  vec4 a = four_coefficients(first), b = four_coefficients(first + 1u);
  vec4 c = four_coefficients(first + 2u);
  return a.xyz * weights.x + vec3(a.w, b.xy) * weights.y + vec3(b.zw, c.x) * weights.z +
         c.yzw * weights.w;
}

vec3 sh_rest(uint first, uint degree, vec3 d) {
  if (degree < 1u) return vec3(0.0);
  float x = d.x, y = d.y, z = d.z;
  float xx = x * x, yy = y * y, zz = z * z;
  vec4 weights = vec4(-0.4886025119029199 * K * y, 0.4886025119029199 * K * z,
                      -0.4886025119029199 * K * x, 0.0);
  if (degree < 2u) return sh_group(first, weights);

  weights.w = 1.0925484305920792 * K * (x * y);
  vec3 sum = sh_group(first, weights);
  sum += sh_group(first + 3u, vec4(-1.0925484305920792 * K * (y * z),
                                   0.31539156525252005 * K * (2.0 * zz - xx - yy),
                                   -1.0925484305920792 * K * (x * z),
                                   0.5462742152960396 * K * (xx - yy)));
  if (degree < 3u) return sum;

  sum += sh_group(first + 6u, vec4(-0.5900435899266435 * K * y * (3.0 * xx - yy),
                                   2.890611442640554 * K * (x * y) * z,
                                   -0.4570457994644658 * K * y * (4.0 * zz - xx - yy),
                                   0.3731763325901154 * K * z * (2.0 * zz - 3.0 * xx - 3.0 * yy)));
  sum += sh_group(first + 9u, vec4(-0.4570457994644658 * K * x * (4.0 * zz - xx - yy),
                                   1.445305721320277 * K * z * (xx - yy),
                                   -0.5900435899266435 * K * x * (xx - 3.0 * yy), 0.0));
  return sum;
}
