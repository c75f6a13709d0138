// Camera paths: a view for each time, for playing and for videos.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "camera/view_state.h"
#include "fluxgs/io/camera_track.h"

namespace fluxgs::camera {

using PathEnd = CameraTrack::End;

/// A way of the camera, see view_at(). Made by the functions below.
struct CameraPath {
  /// Eye, target, orientation (w, x, y, z), logarithm of the distance, field of view.
  using Pose = std::array<double, 12>;
  struct Key {
    double knot = 0;
    Pose pose{};
  };
  /// Ascending. Those of a closed way begin before knot 0 and end after `span`: the neighbours of
  /// the first and the last are there.
  std::vector<Key> keys = {};
  double span = 0;              ///< of the knots, ≥ 0
  double smoothness = 1;        ///< factor of the tangents, 0…1
  bool of_longer_side = false;  ///< the fields of view are those of the image's longer side
  /// Given: the camera looks at the target with this up. Else it turns as the orientations do.
  std::optional<glm::dvec3> up = {};
  /// The way up to each of even steps of the knots, for a constant speed. Empty: knots are seconds.
  std::vector<double> ways = {};
  double seconds = 1;  ///< once through, > 0
  PathEnd end = PathEnd::stops;
};

/// The view after a time, ≥ 0: at the end, again from the beginning, or on the way back. `size` of
/// the image, pixels.
ViewState view_at(const CameraPath& path, double seconds, const glm::dvec2& size);

/// True if the path is over by then.
inline bool is_over(const CameraPath& path, double seconds) {
  return path.end == PathEnd::stops && seconds >= path.seconds;
}

/// Smoothly through views, of which there is at least one, at constant speed: positions on a
/// centripetal Catmull-Rom spline, turns the shorter way. Speed is that of the eye and of the image
/// together, so that turns on the spot take time. A closed path goes on from the last view to the
/// first and repeats.
CameraPath path_through(std::span<const ViewState> views, bool closed, double seconds);

/// Once round the view's target, about `up` (a unit vector), from the view, and again.
CameraPath orbit_path(const ViewState& view, const glm::dvec3& up, double seconds);

/// SuperSplat's animation.
CameraPath path_of(const CameraTrack& track);

/// A path that is played.
struct Playback {
  std::shared_ptr<const CameraPath> path;
  double elapsed = 0;  ///< seconds
};

}  // namespace fluxgs::camera
