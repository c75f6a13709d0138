// Runs a viewer on a thread of its own, for an app whose main thread must never wait for the GPU.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/scene_benchmark.h"
#include "viewer/presenter.h"
#include "viewer/scene_loading.h"

namespace fluxgs::viewer {

/// The state of a session, for the app to show.
struct SessionState {
  LoadState loading;
  bool has_scene = false;   ///< there is one to look at
  bool drawn = false;       ///< and an image of it was shown
  bool coarse = false;      ///< an image was shown of what has come of a scene that is loaded
  std::uint64_t shown = 0;  ///< which loading it is of, by the number that load() gave; 0: none
  bool flipped = false;
  Motion motion = Motion::none;
  ViewerStats stats;
  std::string error;  ///< of drawing, one line; it is over until there is another scene, or window
  int contexts = 0;   ///< how many were made: more than 1 means that some were lost
  std::size_t dropped = 0;    ///< splats of the file that were left out for a NaN or infinity
  double first_frame_ms = 0;  ///< from begin of loading until the first image was shown
};

/// Every function may be called from one thread, the shell's main thread, and image(), scene() and
/// draw_now() from any. These three and the destructor, which may run on another thread, wait for
/// the drawing thread, and so for a scene that is being uploaded.
class Session {
 public:
  /// `screen` is used on the session's thread only, and gone before the session is.
  explicit Session(std::unique_ptr<Screen> screen);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // The window. Images of another size may be wanted at any time.
  void surface_created(void* window);
  /// In pixels, and how many of them are a dp (1/160 inch).
  void surface_changed(int width, int height, double density);
  /// Returns when nothing is drawn in the window any more: at once, or after the frame that is
  /// being shown.
  void surface_destroyed();

  /// Opens a scene from a descriptor, see SceneLoading, and looks at it from `saved` if given.
  /// The scene before stays until then. Returns a number, from 1 on, by which it is known.
  std::uint64_t load(int descriptor, const std::string& name, const LoadLimits& limits,
                     const std::optional<SavedView>& saved = {});
  void cancel_loading();

  /// The display is about to show another frame; `seconds` on any clock that goes on. Returns
  /// whether others are wanted: not, once all is at rest, until one of the other functions is
  /// called.
  bool frame(double seconds);

  /// Draws a frame of the scene that is shown, if one is, and returns once it is handed to the
  /// screen.
  void draw_now();

  void touch(TouchPhase phase, int changed, std::vector<Finger> fingers, double seconds);
  void turn(const DevicePose& pose);
  void set(const ViewerSettings& settings);
  void set_heat(const Heat& heat);
  /// See Presenter::set_limits().
  void set_driver_limits(const render::DriverLimits& limits);
  void flip_up();
  void reset_view();
  /// See Viewer::drift().
  void drift(bool on);
  /// See Viewer::walk(), Viewer::stick().
  void walk(bool on);
  void stick(double right, double ahead);
  /// Of a mouse or a keyboard, `seconds` as in touch().
  void handle(const WindowEvent& event, double seconds);
  /// See Viewer::go_to().
  void go_to(const SavedView& saved);

  /// The path that play() plays; returns its seconds of once through.
  double set_path(camera::CameraPath path);
  /// See Viewer::play(); does nothing where no path was set.
  void play(bool on);
  /// Gives back what is drawn with; the next frame makes it again.
  void free_graphics();

  /// The drawing thread, by the system's number; 0 before it runs.
  int drawing_thread() const { return drawing_thread_; }
  /// Time of the processor that the drawing thread took for the last frame; waiting does not count.
  std::chrono::nanoseconds frame_work() const { return std::chrono::nanoseconds(frame_work_); }

  SessionState state() const;
  std::optional<SavedView> saved_view() const;
  /// The image of the present view, RGBA, as large as the window and as sharp as it is at rest.
  /// Or the last one, reduced until its longer side is `longest` pixels. Nothing where there is
  /// none, or where it is not `of` the scene with this number (0: any).
  std::optional<Image<std::uint8_t>> image(int longest = 0, std::uint64_t of = 0);
  /// The scene that is shown, or nothing; one that was loaded but not shown yet is taken up.
  std::shared_ptr<const render::RenderCloud> scene();
  /// bench::driver_json(), once there is a context; else empty.
  std::string driver() const;

  /// Measures instead of drawing to the screen; does nothing without a scene.
  void start_benchmark(const bench::SceneBenchmarkPlan& plan);
  /// `why` is what the result says of it: a call, heat.
  void stop_benchmark(const std::string& why) { benchmark_.stop(why); }
  RunState benchmark() const { return benchmark_.state(); }

  /// Makes a video of the path that was set, into the window of an encoder, whose ownership is
  /// passed: every frame exact, nothing drawn to the screen meanwhile. No other one may be running.
  void start_video(void* window, const VideoPlan& plan);
  void stop_video(const std::string& why) { video_.stop(why); }
  RunState video() const { return video_.state(); }

  /// Acts as if the GPU had been reset (tests, debugging).
  void lose_context();

 private:
  using Task = std::function<void()>;
  void post(Task task);
  void post_and_wait(Task task);
  void run();
  // On the drawing thread:
  void run_tasks();
  std::optional<double> take_frame();
  void take_scene();
  bool has_whole_scene() const { return cloud_ && !is_coarse_; }
  void draw_frame(double seconds);
  void give_up(const Error& error);
  Expected<bench::SceneBenchmark> measure(const bench::SceneBenchmarkPlan& plan);
  void run_benchmark(const bench::SceneBenchmarkPlan& plan);
  std::shared_ptr<const camera::CameraPath> path() const;
  void publish();
  void publish_driver();
  Expected<RunResult> film(void* window, const VideoPlan& plan);

  // The drawing thread's own
  std::optional<Presenter> presenter_;
  std::optional<double> last_frame_;
  std::shared_ptr<const render::RenderCloud> cloud_;
  std::uint64_t cloud_number_ = 0;  // of its loading
  bool is_coarse_ = false;          // the rest of it is still to come
  std::optional<InitialView> initial_;

  // Of both
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  std::optional<double> frame_wanted_;
  bool resting_ = false;  // no frame is wanted
  std::string driver_;
  bool stops_ = false;
  SceneLoading loading_;
  std::uint64_t loadings_ = 0;
  std::optional<SavedView> saved_wanted_;
  std::chrono::steady_clock::time_point load_began_;
  SessionState state_;
  std::optional<SavedView> saved_;
  std::shared_ptr<const camera::CameraPath> path_;
  WatchedRun benchmark_, video_;
  std::atomic<int> drawing_thread_ = 0;
  std::atomic<std::chrono::nanoseconds::rep> frame_work_ = 0;

  std::thread thread_;
};

}  // namespace fluxgs::viewer
