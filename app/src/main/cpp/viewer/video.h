// The frames of a video along a camera path.
#pragma once

#include <cstdint>
#include <functional>

#include "camera/path.h"
#include "fluxgs/error.h"
#include "viewer/watched_run.h"

namespace fluxgs::viewer {

struct VideoPlan {
  int width = 1920, height = 1080;  ///< px
  double fps = 30;                  ///< frames a second
};

/// Frames of once through a path, at least one; one that returns goes there and back.
int frame_count(const camera::CameraPath& path, double fps);

/// Draws the view of a frame and hands it on with its time from the beginning.
using FrameMaker =
    std::function<Expected<void>(const camera::ViewState& view, std::int64_t nanoseconds)>;

/// Makes every frame of a path, in order, once each, frame i at i / fps seconds. Before each it
/// asks `goes_on` (done, all); stopped early where that says no. Ends with the first frame that
/// fails.
Expected<RunResult> make_frames(const camera::CameraPath& path, const VideoPlan& plan,
                                const FrameMaker& make,
                                const std::function<bool(int done, int all)>& goes_on);

}  // namespace fluxgs::viewer
