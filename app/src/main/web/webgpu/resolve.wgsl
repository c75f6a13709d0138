// Copies the blended image to the canvas, whose format limits and rounds it: the twin of shaders/resolve.frag.
@group(0) @binding(0) var blended: texture_2d<f32>;
@group(0) @binding(1) var<uniform> copied: Copied;

struct Copied {
  ratio: vec2f,  // from pixels of the canvas to those of the blended image
  size: vec2f,   // of the part of it that is drawn, px
}

@vertex
fn whole_canvas(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  let corner = vec2f(f32((vertex & 1u) << 2u), f32((vertex & 2u) << 1u));
  return vec4f(corner - 1.0, 0.0, 1.0);
}

@fragment
fn resolve(@builtin(position) position: vec4f) -> @location(0) vec4f {
  let at = position.xy * copied.ratio - 0.5;
  let low = floor(at);
  let f = at - low;
  let last = copied.size - 1.0;
  let a = vec2i(clamp(low, vec2f(0.0), last));
  let b = vec2i(clamp(low + 1.0, vec2f(0.0), last));
  let top = mix(textureLoad(blended, a, 0), textureLoad(blended, vec2i(b.x, a.y), 0), f.x);
  let bottom = mix(textureLoad(blended, vec2i(a.x, b.y), 0), textureLoad(blended, b, 0), f.x);
  return vec4f(mix(top, bottom, f.y).rgb, 1.0);
}
