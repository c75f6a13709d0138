#include "viewer/video.h"

#include <algorithm>
#include <cmath>

namespace fluxgs::viewer {

int frame_count(const camera::CameraPath& path, double fps) {
  const double there_and_back = path.end == camera::PathEnd::returns ? 2 : 1;
  constexpr double kMost = 1e6;
  return static_cast<int>(std::clamp(std::round(there_and_back * path.seconds * fps), 1.0, kMost));
}

Expected<RunResult> make_frames(const camera::CameraPath& path, const VideoPlan& plan,
                                const FrameMaker& make,
                                const std::function<bool(int done, int all)>& goes_on) {
  const int all = frame_count(path, plan.fps);
  for (int i = 0; i < all; ++i) {
    if (!goes_on(i, all)) return RunResult{.rows = {}, .stopped = "stopped"};
    const double seconds = i / plan.fps;
    const camera::ViewState view = camera::view_at(path, seconds, {plan.width, plan.height});
    if (auto made = make(view, std::llround(1e9 * seconds)); !made)
      return std::unexpected(made.error());
  }
  goes_on(all, all);
  return RunResult{};
}

}  // namespace fluxgs::viewer
