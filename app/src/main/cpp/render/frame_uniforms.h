// The constants of a frame as the shaders read them.
#pragma once

#include <array>
#include <cstdint>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"

namespace fluxgs::render {

/// The twin of the uniform block Frame in shaders/frame.glsl (std140).
struct FrameUniforms {
  std::array<float, 4> rotation_row0, rotation_row1, rotation_row2;
  std::array<float, 4> camera_centre;
  std::array<float, 4> focal_centre;
  std::array<float, 4> slope_limits;
  std::array<float, 2> target_size;
  float alpha_min, alpha_max;
  float dilation, near_plane;
  std::uint32_t splat_count, sh_degree;
};
static_assert(sizeof(FrameUniforms) == 128, "std140 wants multiples of 16 bytes, without gaps");

/// Fails, naming the field, on a camera or options that no picture can be made with: sizes or
/// focal lengths that are not positive, anything not finite, cut-offs outside (0, 1), a degree
/// outside 0…3.
Expected<void> check_view(const Camera& camera, const RenderOptions& options);

/// `origin` is the world point that the scene's positions are relative to; `sh_degree` the
/// scene's own. Precondition: check_view() passed.
FrameUniforms make_frame_uniforms(const Camera& camera, const RenderOptions& options,
                                  const glm::dvec3& origin, std::uint32_t splat_count,
                                  int sh_degree);

}  // namespace fluxgs::render
