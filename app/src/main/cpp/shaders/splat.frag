#version 310 es
// One splat at one pixel; the blend (SRC_ALPHA, ONE_MINUS_SRC_ALPHA) multiplies the colour. Front to
// back it multiplies by the transmittance, and the colour comes multiplied.
// α is computed from the exact pixel centre and not from interpolated coordinates: those err with
// the rounding of corners to the sub-pixel grid, visibly so on needles.
precision highp float;
precision highp int;

#include "frame.glsl"

flat in highp vec2 v_offset;
flat in highp vec4 v_shape;  // xx, xy, yy, level
flat in highp vec3 v_color;

layout(location = 0) out highp vec4 out_color;

void main() {
  vec2 pixel = gl_FragCoord.xy;
  float u = v_shape.x * pixel.x + (v_shape.y * pixel.y + v_offset.x);
  float v = v_shape.z * pixel.y + v_offset.y;
  float level = v_shape.w - u * u - v * v;
  // First: a driver of Xclipse loses fragments whose discard comes before
  out_color = vec4(v_color, min(exp2(level), frame.alpha_max));
#ifdef FRONT_TO_BACK
  out_color.rgb *= out_color.a;
#endif
  if (level < frame.level_min) discard;
}
