// Initial view of a scene: a camera of the .glb.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/error.h"

namespace fluxgs {

/// In the frame of the SplatCloud; camera axes x right, y down, z forward (OpenCV).
struct InitialView {
  glm::dvec3 position{0.0};            ///< of the eye, scene units
  glm::dquat orientation{1, 0, 0, 0};  ///< camera → world, of unit length
  /// Field of view over the image's height, radians, 0…π; in one that is higher than wide we show
  /// as much across.
  double fov_y = 0.87;
  glm::dvec3 up{0, -1, 0};  ///< what is up in the scene, of unit length
  int image_width = 0;      ///< of the images that the scene was trained with, pixels; 0: not known
  int image_height = 0;     ///< likewise
};

/// True for finite numbers within their ranges, and vectors of unit length.
bool is_sound(const InitialView& view);

/// The same .glb with a perspective camera at the top level of its default scene, before other
/// nodes' cameras (glTF 2.0, section 3.10); `extras.up` of its node is the scene's up in glTF's
/// frame, `extras.image_size` the size of the images. Fails on what is no .glb, on one without a
/// scene and on numbers that are not finite or out of their range.
Expected<std::vector<std::byte>> with_initial_view(std::span<const std::byte> glb,
                                                   const InitialView& view,
                                                   const std::string& name);

/// The most bytes that with_initial_view() adds.
inline constexpr std::size_t kMaxInitialViewBytes = 680;

}  // namespace fluxgs
