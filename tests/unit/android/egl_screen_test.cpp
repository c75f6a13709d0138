// The screen of a phone over an EGL and windows that are played: every order in which windows come,
// change, fail and go.
#include "platform/android/egl_screen.h"

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mock_egl.h"

namespace fluxgs::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class EglScreenTest : public testing::Test {
 protected:
  void SetUp() override {
    auto gl = host::HostContext::create(host::HostGl::osmesa);
    if (!gl) GTEST_SKIP() << gl.error().message();
    mock = {};
    mock.gl = std::move(*gl);
    screen_ = android::make_egl_screen();
  }
  void TearDown() override {
    screen_.reset();
    EXPECT_THAT(mock.misuse, IsEmpty());
    EXPECT_THAT(mock.surfaces, IsEmpty());
    EXPECT_THAT(mock.contexts, IsEmpty());
    if (mock.initialized) {
      EXPECT_TRUE(mock.terminated && mock.thread_released);
    }
    for (const auto& window : windows_) EXPECT_EQ(window->references, 0);
    mock.gl.reset();
  }

  ANativeWindow* new_window() {
    return windows_.emplace_back(std::make_unique<ANativeWindow>()).get();
  }
  /// As the session does: a context that is lost is made again.
  Expected<bool> present(int width = 8, int height = 8) {
    if (screen_->api() == nullptr || screen_->api()->lost)
      if (const auto made = screen_->make_context(); !made) return std::unexpected(made.error());
    return screen_->present([this] { ++drawn_; }, width, height);
  }
  /// With a context, and a window that has shown something.
  void begin() {
    if (screen_->api() == nullptr) {
      EXPECT_EQ(present(), true);
    }
  }
  void expect_gone(const ANativeWindow* window) {
    EXPECT_EQ(window->references, 0);
    EXPECT_EQ(window->connected, nullptr);
  }

  std::unique_ptr<viewer::Screen> screen_;
  long drawn_ = 0;  ///< images into windows
  std::vector<std::unique_ptr<ANativeWindow>> windows_;
};

TEST_F(EglScreenTest, ShowsImagesInAWindow) {
  EXPECT_EQ(present(), false) << "there is no window yet";
  ANativeWindow* window = new_window();
  screen_->attach(window);
  EXPECT_TRUE(screen_->has_window());
  EXPECT_EQ(present(), true);
  EXPECT_EQ(present(), true);
  EXPECT_EQ(window->shown, 2);
  EXPECT_EQ(window->geometry, 1) << "fast, 4 bytes a pixel, 8 bits a color";
  screen_->detach();
  expect_gone(window);
  EXPECT_EQ(present(), false);
}

TEST_F(EglScreenTest, AnotherSizeMeansOtherBuffers) {
  ANativeWindow* window = new_window();
  screen_->attach(window);
  EXPECT_EQ(present(8, 8), true);
  const EGLSurface before = window->connected;
  EXPECT_EQ(present(8, 8), true);
  EXPECT_EQ(window->connected, before);
  EXPECT_EQ(present(4, 8), true);
  EXPECT_NE(window->connected, before);
}

TEST_F(EglScreenTest, AWindowThatIsGoingIsNoError) {
  for (const EGLint error : {EGL_BAD_SURFACE, EGL_BAD_NATIVE_WINDOW})
    for (const char* function : {"eglCreateWindowSurface", "eglMakeCurrent", "eglSwapBuffers"}) {
      screen_->attach(new_window());
      begin();
      screen_->attach(new_window());
      mock.failures[function] = {error};
      EXPECT_EQ(present(), false) << function << ' ' << error;
      EXPECT_EQ(present(), true) << function << ' ' << error;
    }
}

TEST_F(EglScreenTest, OtherErrorsAreNamedAndOver) {
  for (const char* function : {"eglCreateWindowSurface", "eglMakeCurrent", "eglSwapBuffers"}) {
    screen_->attach(new_window());
    begin();
    screen_->attach(new_window());
    mock.failures[function] = {EGL_BAD_ALLOC};
    const auto shown = present();
    ASSERT_FALSE(shown) << function;
    EXPECT_THAT(shown.error().message(), HasSubstr(std::string(function) + ": failed with error"));
    EXPECT_EQ(present(), true) << function;
  }
}

TEST_F(EglScreenTest, ALostContextIsMarkedAndItsWindowLetGo) {
  ANativeWindow* window = new_window();
  screen_->attach(window);
  EXPECT_EQ(present(), true);
  mock.lost = true;
  EXPECT_FALSE(present());
  EXPECT_TRUE(screen_->api()->lost);
  screen_->detach();  // before anything is made again
  expect_gone(window);
  ANativeWindow* other = new_window();
  screen_->attach(other);
  EXPECT_EQ(present(), true);
  EXPECT_EQ(other->shown, 1);
}

TEST_F(EglScreenTest, ALostContextIsMadeAgainInTheSameWindow) {
  ANativeWindow* window = new_window();
  screen_->attach(window);
  EXPECT_EQ(present(), true);
  mock.lost = true;
  EXPECT_FALSE(present());
  EXPECT_EQ(present(), true);
  EXPECT_EQ(window->shown, 2);
}

TEST_F(EglScreenTest, ContextsThatCannotBeMadeAreNamedAndTriedAgain) {
  const std::array<std::pair<const char*, int>, 6> functions{{{"eglGetDisplay", 1},
                                                              {"eglInitialize", 1},
                                                              {"eglChooseConfig", 1},
                                                              {"eglCreateContext", 2},
                                                              {"eglCreatePbufferSurface", 1},
                                                              {"eglMakeCurrent", 2}}};
  screen_->attach(new_window());
  for (const auto& [function, times] : functions) {
    mock.failures[function].assign(static_cast<std::size_t>(times), EGL_BAD_ALLOC);
    const auto made = screen_->make_context();
    ASSERT_FALSE(made) << function;
    EXPECT_EQ(made.error().file, "EGL") << function;
    mock.failures.clear();
  }
  EXPECT_EQ(present(), true);
}

TEST_F(EglScreenTest, ADriverWithoutRobustnessWillDo) {
  mock.failures["eglCreateContext"] = {EGL_BAD_ATTRIBUTE};
  screen_->attach(new_window());
  EXPECT_EQ(present(), true);
}

/// Steps of a random life: each may come at any time.
class Life {
 public:
  explicit Life(unsigned seed) : random_(seed) {}

  int step() { return std::uniform_int_distribution(0, 9)(random_); }
  template <class T, std::size_t N>
  T one_of(const std::array<T, N>& all) {
    return all[std::uniform_int_distribution<std::size_t>(0, N - 1)(random_)];
  }

 private:
  std::mt19937 random_;
};

TEST_F(EglScreenTest, AVideoHasItsOwnWindowAndTimes) {
  ANativeWindow* window = new_window();
  screen_->attach(window);
  EXPECT_EQ(present(), true);
  ANativeWindow* encoder = new_window();
  ASSERT_TRUE(screen_->begin_video(encoder));
  int drawn = 0;
  for (const long time : {0L, 33'333'333L, 66'666'667L})
    ASSERT_TRUE(screen_->video_frame(
        [&] {
          ++drawn;
          EXPECT_EQ(mock.current, encoder->connected) << "into the encoder's framebuffer";
        },
        time));
  EXPECT_EQ(drawn, 3);
  EXPECT_EQ(encoder->shown, 3);
  EXPECT_THAT(encoder->times, testing::ElementsAre(0, 33'333'333, 66'666'667));
  EXPECT_NE(mock.current, window->connected) << "which may be taken away at any time";
  EXPECT_EQ(present(), true) << "the screen, between the frames";
  EXPECT_EQ(mock.current, window->connected);
  screen_->detach();
  ASSERT_TRUE(screen_->video_frame([] {}, 1)) << "the window may go meanwhile";
  screen_->end_video();
  expect_gone(encoder);
  EXPECT_EQ(encoder->shown, 4);
}

TEST_F(EglScreenTest, AVideoThatFailsLetsGoOfItsWindow) {
  ASSERT_TRUE(screen_->make_context());
  for (const char* function : {"eglCreateWindowSurface", "eglMakeCurrent",
                               "eglPresentationTimeANDROID", "eglSwapBuffers"}) {
    ANativeWindow* encoder = new_window();
    mock.failures[function] = {EGL_BAD_ALLOC};
    auto failed = screen_->begin_video(encoder);
    if (failed) failed = screen_->video_frame([] {}, 0);
    ASSERT_FALSE(failed) << function;
    EXPECT_THAT(failed.error().message(), HasSubstr(function));
    screen_->end_video();
    expect_gone(encoder);
    mock.failures.clear();
    screen_->attach(new_window());
    EXPECT_EQ(present(), true) << "the screen goes on";
  }
  mock.has_times = false;
  ANativeWindow* encoder = new_window();
  const auto without = screen_->begin_video(encoder);
  ASSERT_FALSE(without);
  EXPECT_THAT(without.error().message(), HasSubstr("EGL_ANDROID_presentation_time"));
  screen_->end_video();
  expect_gone(encoder);
}

TEST_F(EglScreenTest, AContextThatIsLostEndsAVideo) {
  ASSERT_TRUE(screen_->make_context());
  ANativeWindow* encoder = new_window();
  ASSERT_TRUE(screen_->begin_video(encoder));
  mock.lost = true;
  EXPECT_FALSE(screen_->video_frame([] {}, 0));
  EXPECT_TRUE(screen_->api()->lost);
  screen_->end_video();
  expect_gone(encoder);
  screen_->attach(new_window());
  EXPECT_EQ(present(), true);
}

TEST_F(EglScreenTest, AVideoWithoutAContextOrToItsEndIsNoLeak) {
  ANativeWindow* encoder = new_window();
  EXPECT_FALSE(screen_->begin_video(encoder));
  ASSERT_TRUE(screen_->make_context());
  ANativeWindow* other = new_window();
  ASSERT_TRUE(screen_->begin_video(other));
  expect_gone(encoder);
  screen_.reset();
  expect_gone(other);
}

TEST_F(EglScreenTest, EveryOrderEndsWithoutALeak) {
  const std::array functions{"eglCreateWindowSurface", "eglMakeCurrent", "eglSwapBuffers",
                             "eglCreateContext", "eglCreatePbufferSurface"};
  const std::array errors{EGL_BAD_SURFACE, EGL_BAD_NATIVE_WINDOW, EGL_BAD_ALLOC, EGL_CONTEXT_LOST};
  const std::array sizes{8, 4, 1};
  long shown = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    Life life(seed);
    for (int i = 0; i < 40; ++i) {
      ANativeWindow* const last = windows_.empty() ? nullptr : windows_.back().get();
      switch (life.step()) {
        case 0:
          screen_->attach(new_window());
          if (last != nullptr) expect_gone(last);
          break;
        case 1:
          screen_->detach();
          if (last != nullptr) expect_gone(last);
          break;
        case 2:
          if (last != nullptr) last->abandoned = true;
          break;
        case 3:
          mock.lost = screen_->api() != nullptr;
          break;
        case 4:
        case 5:
          mock.failures[life.one_of(functions)].push_back(life.one_of(errors));
          break;
        default:
          if (const auto image = present(life.one_of(sizes)); image) shown += *image ? 1 : 0;
      }
      ASSERT_THAT(mock.misuse, IsEmpty()) << "seed " << seed << ", step " << i;
    }
    // Whatever was: a new window works once nothing fails any more
    mock.failures.clear();
    screen_->attach(new_window());
    static_cast<void>(present());  // it may find that the context is lost
    ASSERT_EQ(present(), true) << "seed " << seed;
    ASSERT_EQ(windows_.back()->connected != nullptr, true);
  }
  EXPECT_GT(shown, 500);
}

}  // namespace
}  // namespace fluxgs::test
