#version 310 es
// Copies the accumulated image to the target, whose format limits and rounds it. ENLARGE: from a
// smaller image, by bilinear interpolation (float textures need not be filterable in ES 3.1).
precision highp float;

layout(binding = 0) uniform highp sampler2D accumulated;
layout(location = 0) out highp vec4 out_color;

#ifdef ENLARGE
layout(location = 0) uniform vec2 ratio;  // smaller over larger size

vec4 sample_at(vec2 at) {
  ivec2 last = textureSize(accumulated, 0) - 1;
  vec2 low = floor(at), f = at - low;
  ivec2 a = clamp(ivec2(low), ivec2(0), last), b = clamp(ivec2(low) + 1, ivec2(0), last);
  vec4 top = mix(texelFetch(accumulated, a, 0), texelFetch(accumulated, ivec2(b.x, a.y), 0), f.x);
  vec4 bottom = mix(texelFetch(accumulated, ivec2(a.x, b.y), 0), texelFetch(accumulated, b, 0), f.x);
  return mix(top, bottom, f.y);
}

void main() { out_color = sample_at(gl_FragCoord.xy * ratio - 0.5); }
#else
void main() { out_color = texelFetch(accumulated, ivec2(gl_FragCoord.xy), 0); }
#endif
