// Reads the camera animation of SuperSplat's settings.json.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/error.h"

namespace fluxgs {

/// An animation of a camera, in the frame of the scene's file: SuperSplat turns scenes by half a
/// turn about z, which is undone here. Up is −y. Between the keys, position, target and field of
/// view are cubic Hermite splines.
struct CameraTrack {
  /// What happens after the last second.
  enum class End { stops, repeats, returns };
  /// The camera at a time.
  struct Key {
    double seconds = 0;        ///< ≥ 0
    glm::dvec3 position{0.0};  ///< of the eye
    glm::dvec3 target{0.0};    ///< in the image's middle
    double fov = 1;            ///< of the image's longer side, radians, 0…π
  };
  std::vector<Key> keys;  ///< at least one, in the order of their times, no two at one time
  double seconds = 0;     ///< > 0, of once through
  double smoothness = 1;  ///< 0…1: factor of the tangents, which are the mean of the slopes beside
  End end = End::stops;   ///< what happens then
};

inline constexpr std::size_t kMaxTrackKeys = 10'000;  ///< more are refused
inline constexpr double kMaxTrackSeconds = 3600;      ///< longer ones are refused

/// The first animation of a settings.json, of version 2 or without a version: the one that
/// SuperSplat's viewer plays. `name` names the file in errors, which also say where in it.
Expected<CameraTrack> read_supersplat_track(std::span<const std::byte> json,
                                            const std::string& name);

}  // namespace fluxgs
