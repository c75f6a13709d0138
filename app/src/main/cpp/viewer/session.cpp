#include "viewer/session.h"

#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <exception>
#include <utility>

namespace fluxgs::viewer {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Processor time of the calling thread so far.
std::chrono::nanoseconds processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

Session::Session(std::unique_ptr<Screen> screen) : presenter_(std::move(screen)) {
  thread_ = std::thread([this] { run(); });
}

Session::~Session() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
    loading_.cancel();
  }
  benchmark_.stop("closed");
  video_.stop("closed");
  changed_.notify_all();
  thread_.join();
}

void Session::post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    resting_ = false;
  }
  changed_.notify_all();
}

void Session::post_and_wait(Task task) {
  std::mutex mutex;
  std::condition_variable finished;
  bool done = false;
  post([&] {
    try {
      task();
    } catch (const std::exception& problem) {  // of memory; who waits goes on all the same
      give_up({"viewer", "memory", problem.what()});
    }
    const std::lock_guard lock(mutex);
    done = true;
    finished.notify_all();
  });
  std::unique_lock lock(mutex);
  finished.wait(lock, [&] { return done; });
}

/// Runs the posted tasks, in order. Also called between the frames of a benchmark.
void Session::run_tasks() {
  for (;;) {
    Task task;
    {
      const std::lock_guard lock(mutex_);
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

std::optional<double> Session::take_frame() {
  const std::lock_guard lock(mutex_);
  return std::exchange(frame_wanted_, std::nullopt);
}

void Session::run() {
  drawing_thread_ = ::gettid();
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stops_ || !tasks_.empty() || frame_wanted_; });
      if (stops_ && tasks_.empty()) break;
    }
    try {
      run_tasks();
      if (const auto frame = take_frame()) {
        const std::chrono::nanoseconds before = processor_time();
        draw_frame(*frame);
        frame_work_ = (processor_time() - before).count();
      }
    } catch (const std::exception& problem) {  // of memory
      give_up({"viewer", "memory", problem.what()});
    }
    publish();
  }
  presenter_.reset();
}

void Session::surface_created(void* window) {
  post([this, window, number = presenter_->gate().offer()] {
    const bool had_failed = presenter_->has_failed();
    presenter_->attach(window, number);
    const std::lock_guard lock(mutex_);
    if (had_failed) state_.error.clear();
  });
}

void Session::surface_changed(int width, int height, double density) {
  post([this, width, height, density] {
    presenter_->resize(width, height, density);
    presenter_->redraw();
  });
}

void Session::surface_destroyed() {
  presenter_->gate().take_back();
  post([this] { presenter_->screen().detach(); });
}

std::uint64_t Session::load(int descriptor, const std::string& name, const LoadLimits& limits,
                            const std::optional<SavedView>& saved) {
  const std::lock_guard lock(mutex_);
  loading_.begin(descriptor, name, limits);
  saved_wanted_ = saved;
  load_began_ = Clock::now();
  state_.first_frame_ms = 0;
  resting_ = false;
  return ++loadings_;
}

void Session::cancel_loading() {
  const std::lock_guard lock(mutex_);
  loading_.cancel();
}

bool Session::frame(double seconds) {
  {
    const std::lock_guard lock(mutex_);
    if (resting_) return false;
    frame_wanted_ = seconds;
  }
  changed_.notify_all();
  return true;
}

void Session::draw_now() {
  post_and_wait([this] {
    if (!presenter_->viewer().is_open()) return;
    presenter_->redraw();
    const auto last = last_frame_;
    draw_frame(last.value_or(0));  // no time passes
    last_frame_ = last;
  });
}

void Session::touch(TouchPhase phase, int changed, std::vector<Finger> fingers, double seconds) {
  post([this, phase, changed, seconds, fingers = std::move(fingers)] {
    presenter_->viewer().touch({phase, changed, fingers, seconds});
  });
}

void Session::turn(const DevicePose& pose) {
  post([this, pose] { presenter_->viewer().turn(pose); });
}

void Session::set(const ViewerSettings& settings) {
  post([this, settings] { presenter_->viewer().set(settings); });
}

void Session::set_heat(const Heat& heat) {
  post([this, heat] { presenter_->viewer().set_heat(heat); });
}

void Session::set_driver_limits(const render::DriverLimits& limits) {
  post([this, limits] { presenter_->set_limits(limits); });
}

void Session::flip_up() {
  post([this] { presenter_->viewer().flip_up(); });
}

void Session::reset_view() {
  post([this] { presenter_->viewer().reset_view(); });
}

void Session::drift(bool on) {
  post([this, on] { presenter_->viewer().drift(on); });
}

void Session::walk(bool on) {
  post([this, on] { presenter_->viewer().walk(on); });
}

void Session::stick(double right, double ahead) {
  post([this, right, ahead] { presenter_->viewer().stick(right, ahead); });
}

void Session::handle(const WindowEvent& event, double seconds) {
  post([this, event, seconds] { presenter_->viewer().handle(event, seconds); });
}

void Session::go_to(const SavedView& saved) {
  post([this, saved] { presenter_->viewer().go_to(saved); });
}

double Session::set_path(camera::CameraPath path) {
  const std::lock_guard lock(mutex_);
  path_ = std::make_shared<const camera::CameraPath>(std::move(path));
  return path_->seconds;
}

std::shared_ptr<const camera::CameraPath> Session::path() const {
  const std::lock_guard lock(mutex_);
  return path_;
}

void Session::play(bool on) {
  const auto path = on ? this->path() : nullptr;
  if (on && !path) return;
  post([this, path] { presenter_->viewer().play(path); });
}

void Session::free_graphics() {
  {
    const std::lock_guard lock(mutex_);
    frame_wanted_.reset();  // else one that was asked for before would make it all again
  }
  post([this] { presenter_->viewer().close(); });
}

void Session::lose_context() {
  post([this] { presenter_->lose_context(); });
}

SessionState Session::state() const {
  const std::lock_guard lock(mutex_);
  SessionState state = state_;
  state.loading = loading_.state();
  return state;
}

std::optional<SavedView> Session::saved_view() const {
  const std::lock_guard lock(mutex_);
  return saved_;
}

std::optional<Image<std::uint8_t>> Session::image(int longest, std::uint64_t of) {
  std::optional<Image<std::uint8_t>> result;
  post_and_wait([&] {
    if (of == 0 || of == cloud_number_) result = presenter_->image(longest);
  });
  return result;
}

std::shared_ptr<const render::RenderCloud> Session::scene() {
  std::shared_ptr<const render::RenderCloud> result;
  post_and_wait([&] {
    take_scene();
    if (has_whole_scene()) result = cloud_;
  });
  return result;
}

std::string Session::driver() const {
  const std::lock_guard lock(mutex_);
  return driver_;
}

/// A scene that has been loaded takes the place of the one before; what has come of it, where there
/// was none.
void Session::take_scene() {
  std::optional<LoadedScene> loaded;
  std::optional<SavedView> saved;
  bool refines = false;
  {
    const std::lock_guard lock(mutex_);
    loaded = loading_.take();
    if (!loaded || (loaded->is_coarse && has_whole_scene())) return;
    refines = is_coarse_ && cloud_number_ == loadings_ && !presenter_->has_failed();
    cloud_number_ = loadings_;
    if (!refines) saved = std::exchange(saved_wanted_, std::nullopt);
    state_.dropped = loaded->dropped;
    state_.error.clear();
    state_.drawn = false;
  }
  cloud_ = std::make_shared<const render::RenderCloud>(std::move(loaded->cloud));
  is_coarse_ = loaded->is_coarse;
  initial_ = loaded->start;
  if (refines)
    presenter_->refine(cloud_);
  else
    presenter_->show(cloud_, initial_, saved);
}

void Session::draw_frame(double seconds) {
  take_scene();
  const double passed = last_frame_ ? std::max(seconds - *last_frame_, 0.0) : 0;
  last_frame_ = seconds;
  const bool was_drawn = presenter_->has_drawn();
  const auto shown = presenter_->frame(passed);
  publish_driver();
  if (!shown) return give_up(shown.error());
  if (!*shown) return;
  const std::lock_guard lock(mutex_);
  if (!was_drawn) state_.first_frame_ms = milliseconds_since(load_began_);
  if (!is_coarse_) state_.shown = cloud_number_;
}

void Session::give_up(const Error& error) {
  presenter_->give_up();
  const std::lock_guard lock(mutex_);
  state_.error = error.message();
  state_.has_scene = false;  // in one step: who sees the error sees no scene beside it
}

/// Publishes the description of a new context.
void Session::publish_driver() {
  const int contexts = presenter_->contexts();
  gl::Api* const api = presenter_->screen().api();
  const std::lock_guard lock(mutex_);
  if (contexts == state_.contexts || api == nullptr) return;
  state_.contexts = contexts;
  driver_ = bench::driver_json(*api);
}

void Session::publish() {
  Viewer& viewer = presenter_->viewer();
  const ViewerStats stats = viewer.stats();
  const std::optional<SavedView> saved = viewer.saved_view();
  const bool rests = presenter_->at_rest();
  if (rests) last_frame_.reset();  // what moves next begins then
  const std::lock_guard lock(mutex_);
  resting_ = rests && tasks_.empty() && !frame_wanted_ && loading_.is_over();
  state_.stats = stats;
  state_.has_scene = has_whole_scene() && !presenter_->has_failed();
  state_.drawn = presenter_->has_drawn() && has_whole_scene() && state_.shown == cloud_number_;
  state_.coarse = presenter_->has_drawn() && is_coarse_;
  state_.flipped = viewer.is_flipped();
  state_.motion = viewer.motion();
  saved_ = saved;
}

void Session::start_benchmark(const bench::SceneBenchmarkPlan& plan) {
  if (benchmark_.begin()) post([this, plan] { run_benchmark(plan); });
}

Expected<bench::SceneBenchmark> Session::measure(const bench::SceneBenchmarkPlan& plan) {
  take_scene();
  const auto cloud = cloud_;  // progress runs tasks, one of which may take up another
  if (!has_whole_scene()) return fail("benchmark", "", "there is no scene to measure");
  if (!cloud->is_whole())
    return fail("benchmark", "memory",
                "there is room for a part of the scene only; a smaller one can be measured");
  presenter_->viewer().close();  // its memory is needed
  const auto device = presenter_->device();
  if (!device) return std::unexpected(device.error());
  publish_driver();
  return bench::benchmark_scene(*presenter_->screen().api(), *cloud, initial_, plan,
                                [this](int done, int all) {
                                  run_tasks();  // the window may be taken away
                                  return benchmark_.report(done, all);
                                });
}

void Session::run_benchmark(const bench::SceneBenchmarkPlan& plan) {
  const auto result = [&]() -> Expected<bench::SceneBenchmark> {
    try {
      return measure(plan);
    } catch (const std::exception& problem) {
      return fail("benchmark", "memory", problem.what());
    }
  }();
  presenter_->redraw();
  if (!result) return benchmark_.finish(std::unexpected(result.error()));
  benchmark_.finish(RunResult{bench::rows_json(*result), result->stopped});
}

void Session::start_video(void* window, const VideoPlan& plan) {
  video_.begin();
  post([this, window, plan] {
    const auto result = [&]() -> Expected<RunResult> {
      try {
        return film(window, plan);
      } catch (const std::exception& problem) {
        return fail("video", "memory", problem.what());
      }
    }();
    presenter_->end_video();
    video_.finish(result);
  });
}

Expected<RunResult> Session::film(void* window, const VideoPlan& plan) {
  if (auto begun = presenter_->begin_video(window); !begun) return std::unexpected(begun.error());
  publish_driver();
  const auto path = this->path();
  if (!path) return fail("video", "", "there is no camera path");
  return make_frames(
      *path, plan,
      [&](const camera::ViewState& view, std::int64_t nanoseconds) {
        return presenter_->video_frame(view, plan, nanoseconds);
      },
      [this](int done, int all) {
        run_tasks();  // the window may be taken away
        return video_.report(done, all);
      });
}

}  // namespace fluxgs::viewer
