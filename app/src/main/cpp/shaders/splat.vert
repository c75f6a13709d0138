#version 310 es
// One corner of the quad that covers a splat down to alpha_min. A tiler runs this again for every
// bin, so all that is heavy is in project.comp.
precision highp float;
precision highp int;

#include "frame.glsl"
#include "record.glsl"

layout(std430, binding = 0) readonly buffer Records { uvec4 records[]; };
layout(std430, binding = 1) readonly buffer Order { uint order[]; };

flat out highp vec2 v_centre;
flat out highp vec3 v_factor;
flat out highp vec4 v_color;  // rgb, opacity

const uint NOTHING = 0xFFFFFFFFu;  // fills the last instance's tail (draw_arguments.comp)
const float PAD = 0.0625;          // px: corners may be moved to a grid as coarse as 1/16 px
const float LARGE = 4096.0;        // px: beyond this a quad's interpolation loses the picture

void main() {
  uint splat = order[uint(gl_InstanceID) * uint(BATCH) + uint(gl_VertexID >> 2)];
  if (splat == NOTHING) {  // All four corners outside, at one point
    v_centre = vec2(0.0);
    v_factor = vec3(0.0);
    v_color = vec4(0.0);
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  Record r = unpack_record(records[2u * splat], records[2u * splat + 1u]);
  v_centre = r.centre;
  v_factor = r.factor;
  v_color = vec4(r.color, r.opacity);

  // The square |u|, |v| ≤ radius, taken to the screen by the factor's inverse: a parallelogram as
  // large as the rectangle along the ellipse's axes, found without an eigendecomposition.
  vec2 corner = vec2(float(gl_VertexID & 1), float((gl_VertexID >> 1) & 1)) * 2.0 - 1.0;
  float radius = sqrt(2.0 * log(r.opacity / frame.alpha_min));
  vec2 reach = vec2(radius + PAD * (r.factor.x + abs(r.factor.y)), radius + PAD * r.factor.z);
  vec2 uv = corner * reach;
  float dy = uv.y / r.factor.z;
  vec2 pixel = r.centre + vec2((uv.x - r.factor.y * dy) / r.factor.x, dy);

  vec2 extent = vec2(reach.x + abs(r.factor.y / r.factor.z) * reach.y, reach.y) /
                vec2(r.factor.x, r.factor.z);
  if (max(extent.x, extent.y) > LARGE) {
    pixel = clamp(r.centre + corner * extent, vec2(0.0), frame.target_size);
  }
  // Row 0 of the target's memory is the top of the picture: no flip here, none when reading.
  gl_Position = vec4(pixel / frame.target_size * 2.0 - 1.0, 0.0, 1.0);
}
