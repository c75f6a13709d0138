// GPU self-test: draws a known scene, compares the picture with a golden one, and where it is wrong
// looks for a way of drawing that this driver gets right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/image.h"
#include "fluxgs/splat_cloud.h"
#include "gl/api.h"
#include "render/driver_limits.h"
#include "render/renderer.h"

namespace fluxgs::bench {

/// PSNR that a picture needs, dB; blended in 8 bits every layer is rounded.
inline constexpr double kLeastPsnr = 45, kLeastPsnrInBytes = 35;

/// Splats of a frame, compared with a projection in doubles.
struct ProjectionCheck {
  std::size_t seen = 0;   ///< that were not hidden
  std::size_t wrong = 0;  ///< of those, in a wrong place

  /// True if more are wrong than may lie at the border of being drawn.
  bool misplaces() const { return wrong * 100 > seen; }
  /// One line if no splat was seen or they are misplaced, else empty.
  std::string fault() const;
};

/// Compares the centres and depths of the first `most` splats in the last frame with a projection
/// in doubles. `camera`: of the image that was blended, of its size. The scene was uploaded as a
/// whole. Waits for the GPU.
Expected<ProjectionCheck> check_projection(const render::Renderer& renderer,
                                           const SplatCloud& scene, const Camera& camera,
                                           double near_plane, std::uint32_t most);

struct DriverCheck {
  bool right = false;           ///< drawn with `limits` the picture is like the golden one
  render::DriverLimits limits;  ///< as few as possible
  double psnr = 0;              ///< of the last picture, dB
  /// One line for each way that went wrong, in the order in which they were tried.
  std::vector<std::string> faults;
  /// The driver's own first few messages about mistakes (KHR_debug, where it has that).
  std::vector<std::string> messages;
};

/// `golden`: 8 bits, RGB or RGBA, the camera's size, over black, drawn with default options and
/// this near plane. The context stays usable; what was drawn before in it is not touched.
DriverCheck check_driver(gl::Api& api, const SplatCloud& scene, const Camera& camera,
                         double near_plane, const Image<std::uint8_t>& golden);

/// One JSON object: renderer and version (of the driver), right, limits, psnr, faults, messages.
std::string to_json(const DriverCheck& check, const gl::Api& api);

}  // namespace fluxgs::bench
