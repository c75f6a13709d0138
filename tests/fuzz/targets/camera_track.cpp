// Camera animations in SuperSplat's settings.json.
#include "fluxgs/io/camera_track.h"

#include <cmath>
#include <numbers>

#include "harness.h"

namespace fluxgs::fuzz {

// Text as values: a node of some 40 bytes for each of two characters, in lists that may have grown
// to twice their size.
FLUXGS_FUZZ_TARGET(camera_track) {
  const Meter meter;
  const auto track = read_supersplat_track(input, "x");
  check_memory(meter.peak(), {64 << 10, 128}, input.size(), 0);
  if (!track) {
    check_error(track.error());
    return Worth::keep;
  }
  require(!track->keys.empty() && track->keys.size() <= kMaxTrackKeys, "a number of keys");
  require(track->seconds > 0 && track->seconds <= kMaxTrackSeconds, "a length");
  require(track->smoothness >= 0 && track->smoothness <= 1, "a smoothness");
  double last = -1;
  for (const CameraTrack::Key& key : track->keys) {
    require(key.seconds > last, "keys in the order of their times");
    last = key.seconds;
    require(std::isfinite(key.position.x + key.position.y + key.position.z), "a position");
    require(std::isfinite(key.target.x + key.target.y + key.target.z), "a target");
    require(key.fov > 0 && key.fov < std::numbers::pi, "a field of view");
  }
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
