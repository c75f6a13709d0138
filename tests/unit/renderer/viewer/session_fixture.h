// A viewer on its own thread, with each implementation of GL behind it, and what its tests ask it.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "platform/host/offscreen_screen.h"
#include "unit/renderer/gl_fixture.h"
#include "viewer/session.h"

namespace fluxgs::viewer::session_test {

constexpr int kWidth = 96, kHeight = 64;

/// A descriptor of a file with these bytes.
int file_of(const std::vector<std::byte>& bytes);

/// A scene of 400 splats, and a file of it that says where to begin.
SplatCloud session_scene(std::uint32_t seed = 1);
std::vector<std::byte> file_with_start(std::uint32_t seed = 1);

/// dB between two images of 8 bits; 0 where their sizes differ.
double psnr(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b);

class SessionTest : public testing::TestWithParam<host::HostGl> {
 protected:
  void SetUp() override;

  void begin() { begin_on(host::make_offscreen_screen(GetParam())); }
  void begin_on(std::unique_ptr<Screen> screen);

  /// Lets the display go on until something holds.
  bool run_until(const std::function<bool(const SessionState&)>& holds);
  bool load(const std::vector<std::byte>& bytes, const std::optional<SavedView>& saved = {});
  /// The image once everything has come to rest.
  Image<std::uint8_t> image();
  /// The number of the display's frames that are wanted after something.
  int comes_to_rest_after(const std::function<void()>& something);

  std::unique_ptr<Session> session_;
  ViewerSettings settings_;
  double time_ = 0;
};

/// A screen that does as another one, for tests that change something of that.
class WrappedScreen : public Screen {
 public:
  explicit WrappedScreen(host::HostGl gl) : real_(host::make_offscreen_screen(gl)) {}
  Expected<gl::Api*> make_context() override { return real_->make_context(); }
  gl::Api* api() override { return real_->api(); }
  void attach(void* window) override { real_->attach(window); }
  void detach() override { real_->detach(); }
  bool has_window() const override { return real_->has_window(); }
  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    return real_->present(draw, width, height);
  }

 private:
  std::unique_ptr<Screen> real_;
};

}  // namespace fluxgs::viewer::session_test
