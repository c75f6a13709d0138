// The constants of a frame as the shaders read them.
#pragma once

#include <array>
#include <cstdint>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "render/scene_constants.h"
#include "render/settings.h"
#include "sort/depth_keys.h"

namespace fluxgs::render {

/// The twin of the uniform block Frame in shaders/frame.glsl (std140).
struct FrameUniforms {
  std::array<float, 4> rotation_row0, rotation_row1, rotation_row2;
  std::array<float, 4> camera_centre;
  std::array<float, 4> focal_centre;
  std::array<float, 4> slope_limits;
  std::array<float, 2> target_size;
  float level_min, alpha_max;
  float dilation, near_plane, depth_spread_max;
  std::uint32_t splat_count, sh_degree;
  float radius_max, weight_min, sort_margin;
  std::uint32_t key_low, key_shift, key_max;
  std::uint32_t unused;
};
static_assert(sizeof(FrameUniforms) == 160, "std140 wants multiples of 16 bytes");

/// ApproximationSettings::max_deviations in the units of ProjectedSplat::factor
/// (shaders/projected_splat.glsl), whose squares are exponents of 2: times √(½·log2 e).
double radius_limit(double max_deviations);

/// Precondition: check_view() (view_check.h) and check_approximation() passed.
FrameUniforms make_frame_uniforms(const Camera& camera, const RenderOptions& options,
                                  const ApproximationSettings& approximation,
                                  const SceneConstants& scene, const sort::DepthKeys& keys);

}  // namespace fluxgs::render
