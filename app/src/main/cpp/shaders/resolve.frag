#version 310 es
// Copies the accumulated image to the target or the window, whose format limits and rounds it.
// ENLARGE: to another number of pixels, by bilinear interpolation (float textures need not be
// filterable in ES 3.1).
precision highp float;

uniform highp sampler2D accumulated;
layout(location = 0) out highp vec4 out_color;

// From pixels of the framebuffer to those of the accumulated image: at * ratio + start.
uniform vec2 ratio;
uniform vec2 start;

#ifdef ENLARGE
uniform vec2 last;  // its last pixel; the texture may be larger

vec4 sample_at(vec2 at) {
  vec2 low = floor(at), f = at - low;
  ivec2 a = ivec2(clamp(low, vec2(0), last)), b = ivec2(clamp(low + 1.0, vec2(0), last));
  vec4 top = mix(texelFetch(accumulated, a, 0), texelFetch(accumulated, ivec2(b.x, a.y), 0), f.x);
  vec4 bottom = mix(texelFetch(accumulated, ivec2(a.x, b.y), 0), texelFetch(accumulated, b, 0), f.x);
  return mix(top, bottom, f.y);
}

void main() { out_color = sample_at(gl_FragCoord.xy * ratio + start - 0.5); }
#else
void main() { out_color = texelFetch(accumulated, ivec2(gl_FragCoord.xy * ratio + start), 0); }
#endif
