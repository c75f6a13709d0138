#include "viewer/screen.h"

namespace fluxgs::viewer {

Expected<void> Screen::begin_video(void*) {
  return fail("video", "", "this machine has no encoder for videos");
}

Expected<void> Screen::video_frame(const std::function<void()>&, std::int64_t) {
  return begin_video(nullptr);
}

}  // namespace fluxgs::viewer
