// Frames of a viewer on a screen: drawn when something changed, and again after the graphics
// context was lost.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "render/driver_limits.h"
#include "viewer/screen.h"
#include "viewer/video.h"
#include "viewer/viewer.h"
#include "viewer/window_gate.h"

namespace fluxgs::viewer {

/// All functions but the constructor and gate() on the screen's thread.
class Presenter {
 public:
  explicit Presenter(std::unique_ptr<Screen> screen) : screen_(std::move(screen)) {}

  Screen& screen() { return *screen_; }
  Viewer& viewer() { return viewer_; }
  const Viewer& viewer() const { return viewer_; }

  /// Sets the faults of the driver (bench/driver_check.h) for the contexts that are made from now
  /// on; one that there is with others is given up.
  void set_limits(const render::DriverLimits& limits);

  /// The window is drawn in through this gate only. Before attach() it is open.
  WindowGate& gate() { return gate_; }

  /// See Screen::attach(). What failed in the last window is tried again in this one, which is
  /// known to the gate by that number.
  void attach(void* window, std::uint64_t number);
  /// Sets the size of the window in pixels; nothing is drawn in one without pixels. `density`:
  /// pixels of a dp.
  void resize(int width, int height, double density = 1);

  /// Another scene: see Viewer::show().
  template <class... Start>
  void show(std::shared_ptr<const render::RenderCloud> cloud, const Start&... start) {
    viewer_.show(std::move(cloud), start...);
    failed_ = drawn_ = false;
    redraw_ = true;
  }

  /// More of the scene that is shown: see Viewer::refine().
  void refine(std::shared_ptr<const render::RenderCloud> cloud) {
    viewer_.refine(std::move(cloud));
    redraw_ = true;
  }

  /// Draws with the next frame() whether anything moved or not.
  void redraw() { redraw_ = true; }
  /// Lets time pass, and draws where that, or anything else, changed the image. Returns whether the
  /// screen shows a new image. A context that is lost is made again, a few times. After an error
  /// nothing is drawn until there is another scene or window.
  Expected<bool> frame(double seconds);
  /// Ends the drawing of this scene, as after an error.
  void give_up();

  /// A device that is not lost, its context current: the screen's, or a new one.
  Expected<render::Device*> device();
  /// The number of devices that were made here: the first, if the screen had none, and those after
  /// a loss.
  int contexts() const { return contexts_; }
  /// Behaves as if the GPU had been reset (tests, debugging).
  void lose_context();

  bool has_failed() const { return failed_; }
  /// True if an image of this scene was shown.
  bool has_drawn() const { return drawn_; }
  /// True if frame() would change nothing until somebody does something.
  bool at_rest() const;

  /// See Screen::begin_video(); fails too where there is no scene. It is opened if it is not.
  Expected<void> begin_video(void* window);
  /// Draws a frame of a video, exactly, and hands it on.
  Expected<void> video_frame(const camera::ViewState& view, const VideoPlan& plan,
                             std::int64_t nanoseconds);
  /// Afterwards the window is drawn again.
  void end_video();

  /// The image of the present view, RGBA, as large as the window and as sharp as it is at rest. Or
  /// the last one, reduced until its longer side is `longest` pixels. Nothing where there is none.
  std::optional<Image<std::uint8_t>> image(int longest);

 private:
  bool can_draw() const;
  Expected<bool> draw();

  std::unique_ptr<Screen> screen_;
  WindowGate gate_;
  Viewer viewer_;  // goes before the screen's context
  render::DriverLimits limits_;
  int width_ = 0, height_ = 0;
  bool failed_ = false;
  bool drawn_ = false;
  bool redraw_ = false;
  int contexts_ = 0;
};

}  // namespace fluxgs::viewer
