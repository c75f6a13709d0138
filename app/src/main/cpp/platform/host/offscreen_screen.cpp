#include "platform/host/offscreen_screen.h"

namespace fluxgs::host {
namespace {

class OffscreenScreen final : public viewer::Screen {
 public:
  explicit OffscreenScreen(HostGl implementation) : implementation_(implementation) {}

  Expected<gl::Api*> make_context() override {
    context_.reset();
    auto made = HostContext::create(implementation_);
    if (!made) return std::unexpected(made.error());
    context_ = std::move(*made);
    return &context_->api();
  }
  gl::Api* api() override { return context_ ? &context_->api() : nullptr; }

  void attach(void* window) override { has_window_ = window != nullptr; }
  void detach() override { has_window_ = false; }
  bool has_window() const override { return has_window_; }

  Expected<bool> present(const std::function<void()>&, int, int) override {
    context_->api().Finish();  // as a display's queue would make it wait
    if (gl::context_lost(context_->api())) return fail("OpenGL", "", "the context was lost");
    return has_window_;
  }

  /// As an encoder would take them: nothing is kept of the frames.
  Expected<void> begin_video(void*) override { return {}; }
  Expected<void> video_frame(const std::function<void()>&, std::int64_t) override {
    context_->api().Finish();
    if (gl::context_lost(context_->api())) return fail("OpenGL", "", "the context was lost");
    return {};
  }

 private:
  HostGl implementation_;
  std::unique_ptr<HostContext> context_;
  bool has_window_ = false;
};

}  // namespace

std::unique_ptr<viewer::Screen> make_offscreen_screen(HostGl implementation) {
  return std::make_unique<OffscreenScreen>(implementation);
}

}  // namespace fluxgs::host
