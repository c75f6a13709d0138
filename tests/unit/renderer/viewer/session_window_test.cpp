// Windows that come and go under a viewer on its own thread, and contexts that are lost.
#include "unit/renderer/viewer/session_fixture.h"

#include <atomic>
#include <semaphore>
#include <thread>

namespace fluxgs::viewer {
namespace {

using namespace std::chrono_literals;
using namespace session_test;

using SessionWindowTest = SessionTest;

TEST_P(SessionWindowTest, TheWindowComesAndGoes) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->surface_destroyed();
  session_->flip_up();
  session_->flip_up();
  session_->surface_changed(40, 60, 3);
  session_->surface_created(this);
  EXPECT_EQ(image().width, 40) << "turned to portrait";
  session_->surface_changed(kWidth, kHeight, 1);
  EXPECT_GT(psnr(image(), before), 50);
  session_->surface_changed(0, 0, 0);
  session_->frame(time_ += 1);
  EXPECT_EQ(session_->state().error, "");
}

TEST_P(SessionWindowTest, GraphicsThatWereFreedAreMadeAgain) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->surface_destroyed();
  session_->free_graphics();
  EXPECT_FALSE(session_->image());
  for (int i = 0; i < 200 && session_->state().stats.memory > 0; ++i)
    std::this_thread::sleep_for(5ms);
  EXPECT_EQ(session_->state().stats.memory, 0U);
  session_->surface_created(this);
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_GT(session_->state().stats.memory, 0U);
  EXPECT_EQ(session_->state().contexts, 1);
}

// The last frame of the display may be waiting still when the app is told to give back memory.
TEST_P(SessionWindowTest, FramesOfBeforeDoNotMakeFreedGraphicsAgain) {
  ASSERT_TRUE(load(file_with_start()));
  for (int i = 0; i < 20; ++i) {
    session_->reset_view();
    session_->frame(time_ += 1.0 / 60);
    session_->free_graphics();
    EXPECT_FALSE(session_->image());
    EXPECT_FALSE(session_->image()) << "nor in the round after";
  }
  image();  // there is one
}

TEST_P(SessionWindowTest, ALostContextIsMadeAgain) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->lose_context();
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.contexts == 2; }));
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_EQ(session_->state().error, "");
}

/// A screen whose context turns out to be lost when its window comes back.
class ForgetfulScreen final : public WrappedScreen {
 public:
  using WrappedScreen::WrappedScreen;
  void attach(void* window) override {
    WrappedScreen::attach(window);
    if (api() != nullptr) api()->lost = true;
  }
};

/// What a window does to images, and how many were to be shown in it.
struct WindowFaults {
  std::atomic<int> going = 0;       ///< so many of them are not shown: it is about to go
  std::atomic<bool> fails = false;  ///< all the time
  std::atomic<int> presented = 0;
};

/// A screen whose windows have faults.
class FaultyScreen final : public WrappedScreen {
 public:
  FaultyScreen(host::HostGl gl, WindowFaults& faults) : WrappedScreen(gl), faults_(faults) {}
  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    ++faults_.presented;
    if (faults_.fails) return fail("EGL", "eglSwapBuffers", "failed with error 0x3003");
    if (faults_.going > 0) {
      --faults_.going;
      return false;
    }
    return WrappedScreen::present(draw, width, height);
  }

 private:
  WindowFaults& faults_;
};

TEST_P(SessionWindowTest, AImageThatAWindowDidNotShowIsShownByTheNextFrame) {
  WindowFaults faults;
  begin_on(std::make_unique<FaultyScreen>(GetParam(), faults));
  faults.going = 3;
  ASSERT_TRUE(load(file_with_start()));
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.drawn; }));
  EXPECT_EQ(faults.going, 0);
  EXPECT_GE(faults.presented, 4);
  EXPECT_EQ(session_->state().error, "");
  session_.reset();  // before the faults
}

TEST_P(SessionWindowTest, AnotherWindowIsAnotherTry) {
  WindowFaults faults;
  begin_on(std::make_unique<FaultyScreen>(GetParam(), faults));
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  faults.fails = true;
  session_->reset_view();
  session_->surface_changed(kWidth, kHeight, 1);
  EXPECT_TRUE(run_until([](const SessionState& s) { return !s.error.empty(); }));
  EXPECT_FALSE(session_->state().has_scene);
  faults.fails = false;
  session_->surface_destroyed();
  session_->surface_created(this);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.has_scene && s.error.empty(); }));
  EXPECT_GT(psnr(image(), before), 50);
  session_.reset();  // before the faults
}

TEST_P(SessionWindowTest, AContextThatIsLostWhileTheWindowIsAwayIsMadeAgain) {
  begin_on(std::make_unique<ForgetfulScreen>(GetParam()));
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  session_->surface_destroyed();
  session_->surface_created(this);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.contexts == 2; }));
  EXPECT_GT(psnr(image(), before), 50);
  EXPECT_EQ(session_->state().error, "");
}

/// What a drawing thread is doing, and may go on with.
struct Progress {
  std::counting_semaphore<> contexts{0}, images{0};  ///< so many may be made
  std::atomic<bool> makes_context = false, presents = false;
  std::atomic<int> presented = 0;
};

/// A screen whose driver takes its time.
class SlowScreen final : public WrappedScreen {
 public:
  SlowScreen(host::HostGl gl, Progress& progress) : WrappedScreen(gl), progress_(progress) {}
  Expected<gl::Api*> make_context() override {
    progress_.makes_context = true;
    progress_.contexts.acquire();
    return WrappedScreen::make_context();
  }
  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    progress_.presents = true;
    progress_.images.acquire();
    ++progress_.presented;
    auto shown = WrappedScreen::present(draw, width, height);
    progress_.presents = false;
    return shown;
  }

 private:
  Progress& progress_;
};

// The main thread must not wait for a driver that compiles, or for a scene that is uploaded.
TEST_P(SessionWindowTest, AWindowGoesWhileADriverIsBusy) {
  Progress progress;
  begin_on(std::make_unique<SlowScreen>(GetParam(), progress));
  session_->load(file_of(file_with_start()), "scene.glb", {});
  ASSERT_TRUE(run_until([&](const SessionState&) { return progress.makes_context.load(); }));
  session_->surface_destroyed();  // returns
  progress.images.release(1000);
  progress.contexts.release(1000);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.contexts == 1; }));
  EXPECT_FALSE(session_->image());
  EXPECT_EQ(progress.presented, 0) << "the window was no longer there";
  session_->surface_created(this);
  session_->draw_now();
  EXPECT_EQ(progress.presented, 1);
  EXPECT_TRUE(run_until([](const SessionState& s) { return s.drawn; }));
  session_.reset();  // before its progress
}

TEST_P(SessionWindowTest, AWindowStaysUntilItsImageIsShown) {
  Progress progress;
  begin_on(std::make_unique<SlowScreen>(GetParam(), progress));
  progress.contexts.release(1000);
  session_->load(file_of(file_with_start()), "scene.glb", {});
  ASSERT_TRUE(run_until([&](const SessionState&) { return progress.presents.load(); }));
  std::thread slow([&] {
    std::this_thread::sleep_for(30ms);
    progress.images.release(1000);
  });
  session_->surface_destroyed();
  EXPECT_FALSE(progress.presents);
  slow.join();
  session_.reset();  // before its progress
}

// A window may go before the drawing thread has heard that it came.
TEST_P(SessionWindowTest, AWindowThatWentAtOnceIsNotDrawnIn) {
  Progress progress;
  progress.images.release(1000);
  begin_on(std::make_unique<SlowScreen>(GetParam(), progress));
  session_->load(file_of(file_with_start()), "scene.glb", {});
  ASSERT_TRUE(run_until([&](const SessionState&) { return progress.makes_context.load(); }));
  std::thread drawing([&] { session_->draw_now(); });
  session_->surface_destroyed();
  for (int i = 0; i < 3; ++i) {
    session_->surface_created(this);
    session_->surface_destroyed();
  }
  progress.contexts.release(1000);
  drawing.join();
  EXPECT_FALSE(session_->image());
  EXPECT_EQ(progress.presented, 0);
  session_.reset();  // before its progress
}

FLUXGS_GL_TEST_SUITE(SessionWindowTest);

}  // namespace
}  // namespace fluxgs::viewer
