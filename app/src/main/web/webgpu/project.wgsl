// Culls and projects: one thread reads one splat, writes its depth key and, where it can touch the image,
// what the draw reads. The twin of shaders/project.glsl, projection.glsl, spherical_harmonics.glsl and
// projected_splat.glsl, which explain the formulas.
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> geometry: array<vec4u>;      // PackedSplats in render/scene_packing.h
@group(0) @binding(2) var<storage, read> coefficients: array<vec2u>;  // half floats
@group(0) @binding(3) var<storage, read_write> projected: array<vec4u>;
@group(0) @binding(4) var<storage, read_write> pairs: array<vec2u>;   // key and number of each splat

override compensated = false;  // a screen filter that compensates opacities

const NO_LEVEL = -1e30;
const MAX_COLOR = 60000.0;
const TO_LEVELS = 0.84932180028802;  // √(½·log2 e)

struct Footprint {
  factor: vec3f,     // xx, xy, yy
  deviation: vec2f,  // px
  share: f32,        // det Σ / det Σ′
}

fn rotate_by_transpose(q: vec4f, v: vec3f) -> vec3f {
  let t = 2.0 * cross(v, q.xyz);
  return v + q.w * t + cross(t, q.xyz);
}

fn is_flat(z: f32, rotation: vec4f, scale: vec3f) -> bool {
  let most = frame.depth_spread_max * z;
  if (max(max(scale.x, scale.y), scale.z) <= most) { return true; }
  let along = rotate_by_transpose(rotation, frame.rotation_row2.xyz) * scale;
  return dot(along, along) <= most * most;
}

fn footprint(p: vec3f, rotation: vec4f, scale: vec3f) -> Footprint {
  let inverse_z = 1.0 / p.z;
  let slope = clamp(p.xy * inverse_z, frame.slope_limits.xz, frame.slope_limits.yw);
  let focal = frame.focal_centre.xy * inverse_z;
  let row_x = frame.rotation_row0.xyz * focal.x - frame.rotation_row2.xyz * (focal.x * slope.x);
  let row_y = frame.rotation_row1.xyz * focal.y - frame.rotation_row2.xyz * (focal.y * slope.y);
  let axes_x = rotate_by_transpose(rotation, row_x) * scale;
  let axes_y = rotate_by_transpose(rotation, row_y) * scale;

  let size = sqrt(max(max(dot(axes_x, axes_x), dot(axes_y, axes_y)), 1.0));
  let inverse = 1.0 / size;
  let ax = axes_x * inverse;
  let ay = axes_y * inverse;
  let d = frame.dilation * inverse * inverse;
  let xx = dot(ax, ax);
  let yy = dot(ay, ay);
  let xy = dot(ax, ay);
  let c = cross(ax, ay);
  let det = dot(c, c) + d * (xx + yy) + d * d;
  let var_x = xx + d;
  let var_y = yy + d;
  let deviation_y = sqrt(var_y);
  let lambda_xx = sqrt(var_y / det);
  let factor = vec3f(lambda_xx, -lambda_xx * (xy / var_y), 1.0 / deviation_y) * inverse;
  return Footprint(factor, vec2f(sqrt(var_x), deviation_y) * size, dot(c, c) / det);
}

fn four_coefficients(at: u32) -> vec4f {
  let halves = coefficients[at];
  return vec4f(unpack2x16float(halves.x), unpack2x16float(halves.y));
}

fn sh_group(first: u32, weights: vec4f) -> vec3f {
  let a = four_coefficients(first);
  let b = four_coefficients(first + 1u);
  let c = four_coefficients(first + 2u);
  return a.xyz * weights.x + vec3f(a.w, b.xy) * weights.y + vec3f(b.zw, c.x) * weights.z + c.yzw * weights.w;
}

fn sh_rest(first: u32, degree: u32, d: vec3f) -> vec3f {
  if (degree < 1u) { return vec3f(0.0); }
  let x = d.x;
  let y = d.y;
  let z = d.z;
  let xx = x * x;
  let yy = y * y;
  let zz = z * z;
  var weights = vec4f(-0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x, 0.0);
  if (degree < 2u) { return sh_group(first, weights); }

  weights.w = 1.0925484305920792 * (x * y);
  var sum = sh_group(first, weights);
  sum += sh_group(first + 3u, vec4f(-1.0925484305920792 * (y * z), 0.31539156525252005 * (2.0 * zz - xx - yy),
                                    -1.0925484305920792 * (x * z), 0.5462742152960396 * (xx - yy)));
  if (degree < 3u) { return sum; }

  sum += sh_group(first + 6u, vec4f(-0.5900435899266435 * y * (3.0 * xx - yy), 2.890611442640554 * (x * y) * z,
                                    -0.4570457994644658 * y * (4.0 * zz - xx - yy),
                                    0.3731763325901154 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy)));
  sum += sh_group(first + 9u, vec4f(-0.4570457994644658 * x * (4.0 * zz - xx - yy), 1.445305721320277 * z * (xx - yy),
                                    -0.5900435899266435 * x * (xx - 3.0 * yy), 0.0));
  return sum;
}

fn color_of(words: vec4u, red: f32, ray: vec3f) -> vec3f {
  let distance2 = dot(ray, ray);
  let direction = ray * select(0.0, inverseSqrt(distance2), distance2 > 0.0);
  let rest = sh_rest(words.w >> 2u, min(words.w & 3u, frame.sh_degree), direction);
  return clamp(vec3f(red, bitcast<vec2f>(words.xy)) + rest, vec3f(0.0), vec3f(MAX_COLOR));
}

fn touches_image(centre: vec2f, half_extent: vec2f) -> bool {
  return all(centre + half_extent > vec2f(0.0)) && all(centre - half_extent < frame.target_size);
}

fn depth_key(depth: f32) -> u32 {
  return min((max(bitcast<u32>(depth), frame.key_low) - frame.key_low) >> frame.key_shift, frame.key_max);
}

fn hide(splat: u32) { projected[2u * splat + 1u].y = bitcast<u32>(f32(NO_LEVEL)); }

// Returns the key.
fn project_splat(splat: u32) -> u32 {
  let centre_level = bitcast<vec4f>(geometry[4u * splat]);
  var level = centre_level.w;
  let ray = centre_level.xyz - frame.camera_centre.xyz;
  let p = vec3f(dot(frame.rotation_row0.xyz, ray), dot(frame.rotation_row1.xyz, ray), dot(frame.rotation_row2.xyz, ray));
  if (!(p.z > frame.near_plane) || !(level >= frame.level_min)) {
    hide(splat);
    return DROPPED;
  }
  let scale_red = bitcast<vec4f>(geometry[4u * splat + 1u]);
  let rotation = bitcast<vec4f>(geometry[4u * splat + 2u]);
  let shape = footprint(p, rotation, scale_red.xyz);
  var seen = true;
  if (compensated) {
    level += 0.5 * log2(shape.share + 1e-30);
    seen = level >= frame.level_min;
    level = max(level, frame.level_min);
  }
  let centre = frame.focal_centre.xy * (p.xy / p.z) + frame.focal_centre.zw;
  let radius = min(sqrt(level - frame.level_min), frame.radius_max) / TO_LEVELS;
  let half_extent = radius * shape.deviation;
  let light = exp2(level) < frame.weight_min * (shape.factor.x * shape.factor.z);
  let drawable = !light && seen && is_flat(p.z, rotation, scale_red.xyz);
  if (!drawable || !touches_image(centre, half_extent)) {
    hide(splat);
    return DROPPED;
  }
  let color = color_of(geometry[4u * splat + 3u], scale_red.w, ray);
  let factor = shape.factor * TO_LEVELS;
  projected[2u * splat] = bitcast<vec4u>(vec4f(centre, factor.xy));
  projected[2u * splat + 1u] = vec4u(bitcast<u32>(factor.z), bitcast<u32>(level), pack2x16float(color.rg),
                                     pack2x16float(vec2f(color.b, 0.0)));
  return depth_key(p.z);
}

@compute @workgroup_size(128)
fn project(@builtin(global_invocation_id) id: vec3u) {
  let splat = id.x;
  if (splat < frame.splat_count) { pairs[splat] = vec2u(project_splat(splat), splat); }
  if (splat == frame.splat_count) { hide(splat); }  // The empty one that fills up the last instance
}
