#include "unit/renderer/viewer/session_fixture.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fluxgs/io/gltf.h"
#include "tests/support/scenes.h"

namespace fluxgs::viewer::session_test {

using namespace std::chrono_literals;

int file_of(const std::vector<std::byte>& bytes) {
  std::FILE* file = std::tmpfile();
  std::fwrite(bytes.data(), 1, bytes.size(), file);
  std::fflush(file);
  const int descriptor = ::dup(::fileno(file));
  std::fclose(file);
  ::lseek(descriptor, 0, SEEK_SET);
  return descriptor;
}

SplatCloud session_scene(std::uint32_t seed) { return test::random_cloud(400, 1, seed); }

std::vector<std::byte> file_with_start(std::uint32_t seed) {
  const InitialView start{.position = {0, 0, -4}, .fov_y = 0.8};
  return *with_initial_view(*encode_glb(session_scene(seed), "scene"), start, "scene");
}

double psnr(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.width != b.width || a.height != b.height) return 0;
  double sum = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double d = (double(a.at(x, y)[c]) - double(b.at(x, y)[c])) / 255;
        sum += d * d;
      }
  return -10 * std::log10(std::max(sum / (3.0 * a.width * a.height), 1e-12));
}

void SessionTest::SetUp() {
  const auto context = host::HostContext::create(GetParam());
  if (!context) GTEST_SKIP() << context.error().message();
  settings_.scale = 1;
  begin();
}

void SessionTest::begin_on(std::unique_ptr<Screen> screen) {
  session_ = std::make_unique<Session>(std::move(screen));
  session_->set(settings_);
  session_->surface_created(this);
  session_->surface_changed(kWidth, kHeight, 1);
}

bool SessionTest::run_until(const std::function<bool(const SessionState&)>& holds) {
  for (int i = 0; i < 3000; ++i) {
    session_->frame(time_ += 1.0 / 60);
    std::this_thread::sleep_for(5ms);
    if (holds(session_->state())) return true;
  }
  return false;
}

bool SessionTest::load(const std::vector<std::byte>& bytes, const std::optional<SavedView>& saved) {
  session_->load(file_of(bytes), "scene.glb", {}, saved);
  return run_until([](const SessionState& s) { return s.drawn || !s.error.empty(); });
}

Image<std::uint8_t> SessionTest::image() {
  for (int i = 0; i < 20; ++i) {
    session_->frame(time_ += 1.0 / 60);
    std::this_thread::sleep_for(5ms);
  }
  const auto taken = session_->image();
  EXPECT_TRUE(taken);
  return taken.value_or(Image<std::uint8_t>(kWidth, kHeight, 4));
}

int SessionTest::comes_to_rest_after(const std::function<void()>& something) {
  something();
  for (int frames = 0; frames < 600; ++frames) {
    if (!session_->frame(time_ += 1.0 / 60)) return frames;
    std::this_thread::sleep_for(5ms);
  }
  return 600;
}

}  // namespace fluxgs::viewer::session_test
