#version 310 es
// Writes what project_point.vert has projected, as it is.
precision highp float;
precision highp int;

flat in highp uvec4 first_words;
layout(location = 0) out highp uvec4 out_first;
#ifndef PROJECTED_SPLAT_HALF
flat in highp uvec4 second_words;
layout(location = 1) out highp uvec4 out_second;
#endif

void main() {
  out_first = first_words;
#ifndef PROJECTED_SPLAT_HALF
  out_second = second_words;
#endif
}
