#include "viewer/session.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "render/renderer.h"

namespace fluxgs::viewer {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxLosses = 3;  // of contexts one after the other, without an image between

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

Session::Session(std::unique_ptr<Screen> screen) : screen_(std::move(screen)) {
  thread_ = std::thread([this] { run(); });
}

Session::~Session() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
    benchmark_stop_ = "closed";
    loading_.cancel();
  }
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

/// What was posted, in order. Also called between the frames of a benchmark.
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
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stops_ || !tasks_.empty() || frame_wanted_; });
      if (stops_ && tasks_.empty()) break;
    }
    try {
      run_tasks();
      if (const auto frame = take_frame()) draw_frame(*frame);
    } catch (const std::exception& problem) {  // of memory
      give_up({"viewer", "memory", problem.what()});
    }
    publish();
  }
  viewer_.close();
  screen_.reset();
}

void Session::surface_created(void* window) {
  post([this, window] {
    screen_->attach(window);
    redraw_ = true;
    if (!std::exchange(failed_, false)) return;
    losses_ = 0;  // what the last window had may be over
    const std::lock_guard lock(mutex_);
    state_.error.clear();
  });
}

void Session::surface_changed(int width, int height, double density) {
  post([this, width, height, density] {
    width_ = width;
    height_ = height;
    viewer_.resize(width, height, density);
    redraw_ = true;
  });
}

void Session::surface_destroyed() {
  post_and_wait([this] { screen_->detach(); });
}

std::uint64_t Session::load(int descriptor, const std::string& name, const LoadLimits& limits,
                            const std::optional<Place>& place) {
  const std::lock_guard lock(mutex_);
  loading_.begin(descriptor, name, limits);
  place_wanted_ = place;
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

void Session::touch(TouchPhase phase, int changed, std::vector<Finger> fingers, double seconds) {
  post([this, phase, changed, seconds, fingers = std::move(fingers)] {
    viewer_.touch({phase, changed, fingers, seconds});
  });
}

void Session::turn(const DevicePose& pose) {
  post([this, pose] { viewer_.turn(pose); });
}

void Session::set(const ViewerSettings& settings) {
  post([this, settings] { viewer_.set(settings); });
}

void Session::set_heat(const Heat& heat) {
  post([this, heat] { viewer_.set_heat(heat); });
}

void Session::flip_up() {
  post([this] { viewer_.flip_up(); });
}

void Session::reset_view() {
  post([this] { viewer_.reset_view(); });
}

void Session::free_graphics() {
  {
    const std::lock_guard lock(mutex_);
    frame_wanted_.reset();  // else one that was asked for before would make it all again
  }
  post([this] { viewer_.close(); });
}

void Session::lose_context() {
  post([this] {
    if (screen_->api() != nullptr) screen_->api()->lost = true;
    redraw_ = true;
  });
}

SessionState Session::state() const {
  const std::lock_guard lock(mutex_);
  SessionState state = state_;
  state.loading = loading_.state();
  return state;
}

std::optional<Place> Session::place() const {
  const std::lock_guard lock(mutex_);
  return place_;
}

BenchmarkState Session::benchmark() const {
  const std::lock_guard lock(mutex_);
  return benchmark_;
}

std::optional<Image<std::uint8_t>> Session::image(int longest, std::uint64_t of) {
  std::optional<Image<std::uint8_t>> result;
  post_and_wait([&] {
    if (!viewer_.is_open() || !drawn_ || (of != 0 && of != cloud_number_)) return;
    if (longest == 0) {
      redraw_ = true;  // on the window, too
      if (!viewer_.draw_sharp()) return;
    }
    auto read = render::read_image(*screen_->api(), viewer_.target(), longest);
    if (read) result = std::move(*read);
  });
  return result;
}

std::shared_ptr<const SplatCloud> Session::scene() {
  std::shared_ptr<const SplatCloud> result;
  post_and_wait([&] {
    take_scene();
    result = cloud_;
  });
  return result;
}

std::string Session::driver() const {
  const std::lock_guard lock(mutex_);
  return driver_;
}

/// A scene that has been loaded takes the place of the one before.
void Session::take_scene() {
  std::optional<SceneFile> loaded;
  std::optional<Place> place;
  {
    const std::lock_guard lock(mutex_);
    loaded = loading_.take();
    if (!loaded) return;
    cloud_number_ = loadings_;
    place = std::exchange(place_wanted_, std::nullopt);
    state_.dropped = loaded->dropped;
    state_.error.clear();
    state_.drawn = false;
  }
  cloud_ = std::make_shared<const SplatCloud>(std::move(loaded->cloud));
  start_ = loaded->start;
  viewer_.show(cloud_, start_, place);
  failed_ = false;
  drawn_ = false;
  losses_ = 0;
  redraw_ = true;
}

Expected<void> Session::make_ready() {
  if (screen_->api() == nullptr) {
    const auto api = screen_->make_context();
    if (!api) return std::unexpected(api.error());
    const std::string driver = bench::driver_json(**api);
    const std::lock_guard lock(mutex_);
    driver_ = driver;
    ++state_.contexts;
  }
  if (viewer_.is_open()) return {};
  redraw_ = true;
  return viewer_.open(*screen_->api(), width_, height_);
}

Expected<void> Session::show_frame() {
  auto done = make_ready();
  if (done) done = viewer_.draw();
  if (!done) return done;
  const auto shown = screen_->present(viewer_.target(), width_, height_);
  if (!shown) return std::unexpected(shown.error());
  redraw_ = !*shown;
  losses_ = 0;
  if (!*shown) return {};
  viewer_.presented();
  if (!std::exchange(drawn_, true)) {
    const std::lock_guard lock(mutex_);
    state_.first_frame_ms = milliseconds_since(load_began_);
    state_.shown = cloud_number_;
  }
  return {};
}

void Session::draw_frame(double seconds) {
  take_scene();
  const double passed = last_frame_ ? std::max(seconds - *last_frame_, 0.0) : 0;
  last_frame_ = seconds;
  if (!screen_->has_window() || width_ < 1 || height_ < 1 || !cloud_ || failed_) return;
  const bool moves = viewer_.advance(passed);
  if (!moves && !redraw_ && viewer_.is_open()) return;
  const auto shown = show_frame();
  if (shown) return;
  gl::Api* api = screen_->api();
  if (api != nullptr && gl::context_lost(*api) && ++losses_ <= kMaxLosses)
    begin_again();
  else
    give_up(shown.error());
}

/// The GPU was reset, or taken away: another context, with everything in it made again.
void Session::begin_again() {
  viewer_.close();
  const auto api = screen_->make_context();
  if (!api) return give_up(api.error());
  redraw_ = true;
  const std::lock_guard lock(mutex_);
  ++state_.contexts;
}

void Session::give_up(const Error& error) {
  failed_ = true;
  viewer_.close();
  const std::lock_guard lock(mutex_);
  state_.error = error.message();
}

/// Whether the next frame of the display would change nothing.
bool Session::rests() const {
  if (!cloud_ || failed_ || !screen_->has_window() || width_ < 1 || height_ < 1) return true;
  return !redraw_ && viewer_.at_rest();
}

void Session::publish() {
  const ViewerStats stats = viewer_.stats();
  const std::optional<Place> place = viewer_.place();
  const bool rests = this->rests();
  if (rests) last_frame_.reset();  // what moves next begins then
  const std::lock_guard lock(mutex_);
  resting_ = rests && tasks_.empty() && !frame_wanted_ && loading_.is_over();
  state_.stats = stats;
  state_.has_scene = cloud_ != nullptr && !failed_;
  state_.drawn = drawn_;
  state_.flipped = viewer_.is_flipped();
  place_ = place;
}

void Session::start_benchmark(const bench::SceneBenchmarkPlan& plan) {
  {
    const std::lock_guard lock(mutex_);
    if (benchmark_.running) return;
    benchmark_ = {};
    benchmark_.running = true;
    benchmark_stop_.reset();
  }
  post([this, plan] { run_benchmark(plan); });
}

void Session::stop_benchmark(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (benchmark_.running && !benchmark_stop_) benchmark_stop_ = why;  // the first is the reason
}

bool Session::report_progress(int done, int all) {
  run_tasks();  // the window may be taken away
  const std::lock_guard lock(mutex_);
  benchmark_.done = done;
  benchmark_.all = all;
  return !benchmark_stop_;
}

Expected<bench::SceneBenchmark> Session::measure(const bench::SceneBenchmarkPlan& plan) {
  take_scene();
  const auto cloud = cloud_;  // progress runs tasks, one of which may take up another
  if (!cloud) return fail("benchmark", "", "there is no scene to measure");
  viewer_.close();  // its memory is needed
  if (screen_->api() == nullptr || gl::context_lost(*screen_->api())) {
    const auto api = screen_->make_context();
    if (!api) return std::unexpected(api.error());
    const std::lock_guard lock(mutex_);
    driver_ = bench::driver_json(**api);
    ++state_.contexts;
  }
  return bench::benchmark_scene(*screen_->api(), *cloud, start_, plan,
                                [this](int done, int all) { return report_progress(done, all); });
}

void Session::run_benchmark(const bench::SceneBenchmarkPlan& plan) {
  const auto result = [&]() -> Expected<bench::SceneBenchmark> {
    try {
      return measure(plan);
    } catch (const std::exception& problem) {
      return fail("benchmark", "memory", problem.what());
    }
  }();
  redraw_ = true;
  const std::lock_guard lock(mutex_);
  benchmark_.running = false;
  if (!result) {
    benchmark_.error = result.error().message();
    return;
  }
  benchmark_.rows = bench::rows_json(*result);
  if (!result->stopped.empty()) benchmark_.stopped = benchmark_stop_.value_or(result->stopped);
}

}  // namespace fluxgs::viewer
