// The constants of a frame: the twin of FrameUniforms in render/frame_uniforms.h.
layout(std140) uniform Frame {  // at binding 0 (gl/program.cpp)
  highp vec4 rotation_row0;  // world → camera, xyz; w unused
  highp vec4 rotation_row1;
  highp vec4 rotation_row2;
  highp vec4 camera_centre;  // xyz, relative to the scene's origin
  highp vec4 focal_centre;   // fx, fy, cx, cy in pixels
  highp vec4 slope_limits;   // x/z at least and at most, y/z at least and at most
  highp vec2 target_size;    // pixels
  highp float level_min;     // log2 of the α below which a splat is cut off
  highp float alpha_max;
  highp float dilation;  // px²
  highp float near_plane;
  highp float depth_spread_max;
  highp uint splat_count;
  highp uint sh_degree;     // to evaluate
  highp float radius_max;   // of a quad, in the units of ProjectedSplat::factor
  highp float weight_min;   // px²/2π: splats with a smaller opacity·√det Σ′ are left out
  highp float sort_margin;  // px around the image in which splats are sorted though not drawn
  highp uint key_low;       // sort/depth_keys.h
  highp uint key_shift;
  highp uint key_max;
} frame;
