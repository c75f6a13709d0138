// A camera animation as SuperSplat writes it.
#pragma once

#include <string>

namespace fluxgs::test {

/// Three seconds round the origin, once and again.
inline std::string some_track() {
  return R"({"version": 2, "animTracks": [{"name": "path", "duration": 3, "frameRate": 30,
    "loopMode": "repeat", "interpolation": "spline", "smoothness": 1, "keyframes":
    {"times": [0, 30, 60], "values": {"position": [0, 1, 4, 4, 1, 0, 0, 1, -4],
     "target": [0, 0, 0, 0, 0, 0, 0, 0, 0], "fov": [60, 60, 60]}}}]})";
}

}  // namespace fluxgs::test
