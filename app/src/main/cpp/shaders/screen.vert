#version 310 es
// One triangle that covers the target. MARK: nearer than everything else.
#ifdef MARK
const highp float DEPTH = -1.0;
#else
const highp float DEPTH = 0.0;
#endif

void main() {
  highp vec2 corner = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1));
  gl_Position = vec4(corner - 1.0, DEPTH, 1.0);
}
