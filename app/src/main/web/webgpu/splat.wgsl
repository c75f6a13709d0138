// Draws the splats in their order, back to front: the twin of shaders/splat.vert and splat.frag, which explain it.
// Rows of WebGPU's images go down, as ours do.
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> projected: array<vec4u>;
@group(0) @binding(2) var<storage, read> order: array<u32>;

struct Corner {
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat) offset: vec2f,
  @location(1) @interpolate(flat) shape: vec4f,  // xx, xy, yy, level
  @location(2) @interpolate(flat) color: vec3f,
}

const PAD = 0.0625;    // px
const LARGE = 4096.0;  // px

@vertex
fn corner_of_splat(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
  let splat = order[instance * BATCH + (vertex >> 2u)];
  let head = bitcast<vec4f>(projected[2u * splat]);
  let tail = projected[2u * splat + 1u];
  let centre = head.xy;
  let factor = vec3f(head.zw, bitcast<f32>(tail.x));
  let level = bitcast<f32>(tail.y);
  var out: Corner;
  out.offset = -vec2f(factor.x * centre.x + factor.y * centre.y, factor.z * centre.y);
  out.shape = vec4f(factor, level);
  out.color = vec3f(unpack2x16float(tail.z), unpack2x16float(tail.w).x);

  let corner = vec2f(f32(vertex & 1u), f32((vertex >> 1u) & 1u)) * 2.0 - 1.0;
  let radius = min(sqrt(max(level - frame.level_min, 0.0)), frame.radius_max);
  let reach = vec2f(radius + PAD * (factor.x + abs(factor.y)), radius + PAD * factor.z);
  let uv = corner * reach;
  let dy = uv.y / factor.z;
  var pixel = centre + vec2f((uv.x - factor.y * dy) / factor.x, dy);
  let extent = vec2f(reach.x + abs(factor.y / factor.z) * reach.y, reach.y) / vec2f(factor.x, factor.z);
  if (max(extent.x, extent.y) > LARGE) {
    pixel = clamp(centre + corner * extent, vec2f(0.0), frame.target_size);
  }
  let position = pixel / frame.target_size * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
  // What is not to be drawn has its four corners at one point outside
  out.position = select(vec4f(position, 0.0, 1.0), vec4f(2.0, 2.0, 0.0, 1.0), level < frame.level_min);
  return out;
}

@fragment
fn layer(in: Corner) -> @location(0) vec4f {
  let pixel = in.position.xy;
  let u = in.shape.x * pixel.x + (in.shape.y * pixel.y + in.offset.x);
  let v = in.shape.z * pixel.y + in.offset.y;
  let level = in.shape.w - u * u - v * v;
  if (level < frame.level_min) { discard; }
  return vec4f(in.color, min(exp2(level), frame.alpha_max));
}
