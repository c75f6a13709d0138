// Viewer of a scene: applies inputs to the view, draws it, and measures the speed.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "camera/navigation.h"
#include "fluxgs/io/initial_view.h"
#include "render/scene_view.h"
#include "viewer/frame_goal.h"
#include "viewer/gestures.h"
#include "viewer/gyroscope.h"
#include "viewer/mouse_and_keys.h"
#include "viewer/saved_view.h"

namespace fluxgs::viewer {

enum class SorterChoice { automatic, gpu, cpu };

/// Settings of the user.
struct ViewerSettings {
  double scale = 0;  ///< of the image that is blended, 0.2…1; 0: what holds the display's rate
  double moving_scale = 1;  ///< the largest of that while something moves, 0.2…1
  SorterChoice sorter = SorterChoice::automatic;
  int sh_degree = 3;                       ///< 0…3
  std::size_t max_splats = 0;              ///< 0: all
  bool gyroscope = false;                  ///< look around by turning the device
  bool measures = true;                    ///< times and counts for ViewerStats, from the GPU
  double frame_seconds = 1.0 / 60;         ///< the shortest of the display
  std::optional<std::size_t> memory = {};  ///< bytes of the GPU, see SceneViewSettings
  glm::dvec3 background{0.0};
  bool wait_for_sorts = false;  ///< every image in the order of its own view, however long it takes
  bool operator==(const ViewerSettings&) const = default;
};

/// Statistics over about the last second.
struct ViewerStats {
  double frames_per_second = 0;       ///< while something moves; 0 at rest
  double goal = 60;                   ///< frames a second that are aimed at
  double frame_ms = 0;                ///< the GPU's, or where it has no clock from frame to frame
  double draw_ms = 0;                 ///< the part of it without the sort; 0 without a clock
  double sort_ms = 0;                 ///< from when the camera moved to an order of that view
  std::uint32_t drawn = 0;            ///< splats that were not culled
  std::size_t shown = 0, splats = 0;  ///< of the scene: for which there is room; all of the file
  int sh_degree = 0, file_sh_degree = 0;  ///< the same for the degree of its harmonics
  int width = 0, height = 0;              ///< of the image that is blended
  double scale = 1;                       ///< of the last image
  std::size_t memory = 0;                 ///< bytes of graphics memory that are taken
  bool reduced = false;  ///< there was no room for all, see SceneView::is_reduced()
  double image = 1;      ///< its width, of the window's: less where memory is short
  double coolest = 1;    ///< the scale that heat allows, where it is not the user's
};

/// Makes a renderer of a scene that needs no GPU.
using MakeSoftwareRenderer =
    std::function<render::SoftwareRenderer(std::shared_ptr<const render::RenderCloud>)>;

/// What moves the view, but for fingers and what they threw.
enum class Motion { none, drift, path, walk };

/// Not thread-safe. Between open() and close() the device must be there, and a context of OpenGL's
/// current; close() may be called without one after it was lost.
class Viewer {
 public:
  explicit Viewer(const ViewerSettings& settings = {}) : settings_(settings) {}

  /// Another scene, from its initial view; or from a saved one, if its values are sound. To be
  /// followed by open().
  void show(std::shared_ptr<const render::RenderCloud> cloud,
            const std::optional<InitialView>& initial, const std::optional<SavedView>& saved = {});
  /// The same, but from where `navigation` stands.
  void show(std::shared_ptr<const render::RenderCloud> cloud, const camera::Navigation& navigation);
  /// More of the scene that is shown, which is looked at from where it was. Its start view should
  /// be known: one that is guessed from a part of a scene is another than that of the whole.
  void refine(std::shared_ptr<const render::RenderCloud> cloud);
  bool has_scene() const { return cloud_ != nullptr; }

  /// Has scenes drawn without the GPU from the next open() on.
  void draw_in_software(MakeSoftwareRenderer make) { make_software_ = std::move(make); }

  /// Where scenes are sorted that the GPU does not sort, from the next open() on.
  void sort_by(sort::MakeBackgroundSort make) { background_sort_ = std::move(make); }

  /// Makes what the scene needs for images of this size, after another scene, on a new device.
  /// Fails as SceneView::open() does.
  Expected<void> open(render::Device& device, int width, int height);
  bool is_open() const { return scene_.has_value(); }
  /// Lets go of all that open() made. The scene and where it is looked at from stay.
  void close();

  /// New settings, for the next frame. Those that need other graphics objects make them then.
  void set(const ViewerSettings& settings);
  const ViewerSettings& settings() const { return settings_; }
  void set_heat(const Heat& heat);

  void resize(int width, int height, double density);

  void touch(const TouchEvent& event);
  /// An event of a window, with its time in seconds since some start.
  void handle(const WindowEvent& event, double seconds);
  void turn(const DevicePose& pose);
  void flip_up();
  void reset_view();
  /// Turns slowly round what is looked at until somebody touches something, or no longer. Does
  /// nothing while fingers touch.
  void drift(bool on);
  /// Plays a path from its beginning, or no longer where it is null.
  void play(std::shared_ptr<const camera::CameraPath> path);
  /// Goes smoothly to a saved view, if its values are sound.
  void go_to(const SavedView& saved);
  /// Walks at eye height, or no longer.
  void walk(bool on);
  /// While people walk: where a thumb's stick points, −1…1 to the right and ahead.
  void stick(double right, double ahead);
  Motion motion() const;
  /// True if the scene stands upside down, compared with how it was shown first.
  bool is_flipped() const;
  /// The present view, to be saved.
  std::optional<SavedView> saved_view() const;

  /// Lets time pass. Whether a frame is to be drawn: something moved, the last one was not final,
  /// or all is at rest and it was of a lower scale than heat allows.
  bool advance(double seconds);
  /// True if nothing changes any more until somebody touches something.
  bool at_rest() const;

  /// Enqueues a frame. Fails as SceneView::draw() does.
  Expected<void> draw();
  /// The same at the scale of a view at rest.
  Expected<void> draw_sharp();

  /// The same of a view and size that are not the window's, in the order of that view. Fails too
  /// where the scene was closed.
  Expected<void> draw_exact(const camera::ViewState& view, int width, int height);

  /// After a frame was handed to the screen.
  void presented();

  /// Waits for the GPU once all is at rest, if it has not spoken of the last frame.
  ViewerStats stats();

  const camera::Navigation& navigation() const { return navigation_; }
  render::SceneView& scene() { return *scene_; }
  /// Precondition: has_scene().
  const render::RenderCloud& cloud() const { return *cloud_; }

 private:
  using Clock = std::chrono::steady_clock;
  Expected<void> make();
  render::SceneViewSettings scene_settings() const;
  Detail wanted_detail() const;
  Expected<void> set_detail(const Detail& detail);
  RenderOptions render_options() const;
  bool rests() const;
  void measure();
  bool needs_remaking(const ViewerSettings& settings) const;
  void begin_navigation();
  void take_up_of(const SavedView& saved);
  template <class Input>
  void steer(Input&& input);

  ViewerSettings settings_;
  MakeSoftwareRenderer make_software_;
  sort::MakeBackgroundSort background_sort_;
  std::shared_ptr<const render::RenderCloud> cloud_;
  std::optional<InitialView> initial_;
  std::optional<SavedView> saved_;  // to begin at
  camera::Navigation navigation_;
  bool navigated_ = false;  // there is a navigation of the scene
  glm::dvec3 first_up_{0.0};
  Gestures gestures_;
  MouseAndKeys mouse_and_keys_;
  Gyroscope gyroscope_;
  glm::ivec2 size_{0};
  render::Device* device_ = nullptr;
  std::optional<render::SceneView> scene_;
  FrameGoal goal_;
  bool stale_ = true;             // the image is not of the present view
  double still_ = 0;              // seconds for which nothing has moved
  std::optional<Detail> detail_;  // of the last image
  bool remake_ = false;           // settings changed that need other graphics objects

  // Times
  std::optional<Clock::time_point> presented_;
  double frame_seconds_ = 0;  // smoothed
  bool measurable_ = false;   // a frame was drawn that was not waited for
  ViewerStats stats_;
};

}  // namespace fluxgs::viewer
