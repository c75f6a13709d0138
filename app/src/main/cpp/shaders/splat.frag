#version 310 es
// One splat at one pixel, premultiplied; the blend (ONE, ONE_MINUS_SRC_ALPHA) does the rest.
// α is computed from the exact pixel centre and not from interpolated coordinates: those err with
// the rounding of corners to the sub-pixel grid, visibly so on needles.
precision highp float;
precision highp int;

#include "frame.glsl"

flat in highp vec2 v_centre;
flat in highp vec3 v_factor;
flat in highp vec4 v_color;

layout(location = 0) out highp vec4 out_color;

void main() {
  vec2 d = gl_FragCoord.xy - v_centre;
  vec2 uv = vec2(v_factor.x * d.x + v_factor.y * d.y, v_factor.z * d.y);
  float alpha = min(frame.alpha_max, v_color.a * exp(-0.5 * dot(uv, uv)));
  if (alpha < frame.alpha_min) discard;
  out_color = vec4(v_color.rgb * alpha, alpha);
}
