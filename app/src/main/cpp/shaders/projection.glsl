// Projection of a 3D Gaussian to its footprint: twin of fluxgs/math/projection.h, which explains it.

// u = xx·d.x + xy·d.y, v = yy·d.y with d = pixel − centre; α = opacity·exp(−½(u² + v²))
struct Footprint {
  vec3 factor;     // xx, xy, yy
  vec2 deviation;  // px
#ifdef COMPENSATED
  float share;  // det Σ / det Σ′ of the covariance without and with the dilation
#endif
};

vec3 rotate_by_transpose(vec4 q, vec3 v) {  // Rᵀ·v for the unit quaternion q = (x, y, z, w)
  vec3 t = 2.0 * cross(v, q.xyz);
  return v + q.w * t + cross(t, q.xyz);
}

// Whether a splat at depth z extends along the view by no more than frame.depth_spread_max × z. Most
// are so small that this is seen at once.
bool is_flat(float z, vec4 rotation, vec3 scale) {
  float most = frame.depth_spread_max * z;
  if (max(max(scale.x, scale.y), scale.z) <= most) return true;
  vec3 along = rotate_by_transpose(rotation, frame.rotation_row2.xyz) * scale;
  return dot(along, along) <= most * most;
}

// The images on the screen of the principal axes, as the rows of J·W·R·diag(s).
void screen_axes(vec3 p, vec4 rotation, vec3 scale, out vec3 axes_x, out vec3 axes_y) {
  float inverse_z = 1.0 / p.z;
  vec2 slope = clamp(p.xy * inverse_z, frame.slope_limits.xz, frame.slope_limits.yw);
  vec2 focal = frame.focal_centre.xy * inverse_z;
  vec3 row_x = frame.rotation_row0.xyz * focal.x - frame.rotation_row2.xyz * (focal.x * slope.x);
  vec3 row_y = frame.rotation_row1.xyz * focal.y - frame.rotation_row2.xyz * (focal.y * slope.y);
  axes_x = rotate_by_transpose(rotation, row_x) * scale;
  axes_y = rotate_by_transpose(rotation, row_y) * scale;
}

Footprint footprint(vec3 axes_x, vec3 axes_y) {
  float size = sqrt(max(max(dot(axes_x, axes_x), dot(axes_y, axes_y)), 1.0));
  float inverse = 1.0 / size;
  vec3 ax = axes_x * inverse, ay = axes_y * inverse;
  float d = frame.dilation * inverse * inverse;
  float xx = dot(ax, ax), yy = dot(ay, ay), xy = dot(ax, ay);
  vec3 c = cross(ax, ay);
  float det = dot(c, c) + d * (xx + yy) + d * d;
  float var_x = xx + d, var_y = yy + d;
  float deviation_y = sqrt(var_y);
  float lambda_xx = sqrt(var_y / det);
  vec3 factor = vec3(lambda_xx, -lambda_xx * (xy / var_y), 1.0 / deviation_y) * inverse;
  vec2 deviation = vec2(sqrt(var_x), deviation_y) * size;
#ifdef COMPENSATED
  return Footprint(factor, deviation, dot(c, c) / det);
#else
  return Footprint(factor, deviation);
#endif
}
