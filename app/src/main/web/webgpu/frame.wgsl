// The constants of a frame: the twin of FrameUniforms in render/frame_uniforms.h and of shaders/frame.glsl,
// which explains them. Comes before the text of each other file.
struct Frame {
  rotation_row0: vec4f,
  rotation_row1: vec4f,
  rotation_row2: vec4f,
  camera_centre: vec4f,
  focal_centre: vec4f,
  slope_limits: vec4f,
  target_size: vec2f,
  level_min: f32,
  alpha_max: f32,
  dilation: f32,
  near_plane: f32,
  depth_spread_max: f32,
  splat_count: u32,
  sh_degree: u32,
  radius_max: f32,
  weight_min: f32,
  sort_margin: f32,
  key_low: u32,
  key_shift: u32,
  key_max: u32,
  unused: u32,
}

// What the sort knows of its keys.
struct State {
  count: u32,  // keys that there are; at first one a splat, then those that were not dropped
  unused0: u32,
  unused1: u32,
  unused2: u32,
  totals: array<u32, 256>,  // how often each digit occurs
  counts: array<u32>,       // [block][digit]: how often in that block; after the scan, in those before
}

const DROPPED = 0xffffffffu;  // the key of a splat that is not sorted
const BLOCK = 2048u;          // keys that a work group sorts
const BATCH = 128u;           // quads of an instance
