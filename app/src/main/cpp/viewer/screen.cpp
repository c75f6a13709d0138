#include "viewer/screen.h"

namespace fluxgs::viewer {

Expected<render::Device*> Screen::make_device() {
  if (auto made = make_context(); !made) return std::unexpected(made.error());
  return device();
}

render::Device* Screen::device() {
  gl::Api* const now = api();
  if (now == nullptr) return nullptr;
  if (!gl_device_ || &gl_device_->api() != now) gl_device_.emplace(*now);
  return &*gl_device_;
}

Expected<void> Screen::begin_video(void*) {
  return fail("video", "", "this machine has no encoder for videos");
}

Expected<void> Screen::video_frame(const std::function<void()>&, std::int64_t) {
  return begin_video(nullptr);
}

}  // namespace fluxgs::viewer
