// The functions of the page: one viewer in one canvas. All are called on the page's thread.
#include <emscripten.h>

#include <array>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/driver_check.h"
#include "platform/web/scene_blocks.h"
#include "platform/web/web_screen.h"
#include "platform/web/worker_sort.h"
#include "render/scaled_camera.h"
#include "viewer/presenter.h"
#include "viewer/session_json.h"

namespace fluxgs::web {
namespace {

/// A view as numbers: target, orientation (w, x, y, z), distance, field of view, up.
constexpr std::size_t kViewNumbers = 12;
using ViewNumbers = std::array<double, kViewNumbers>;

ViewNumbers numbers_of(const viewer::SavedView& s) {
  const camera::ViewState& v = s.view;
  return {v.target.x,      v.target.y,      v.target.z,      v.orientation.w,
          v.orientation.x, v.orientation.y, v.orientation.z, v.distance,
          v.fov,           s.up.x,          s.up.y,          s.up.z};
}

viewer::SavedView view_of(const double* n) {
  viewer::SavedView s;
  s.view.target = {n[0], n[1], n[2]};
  s.view.orientation = glm::dquat(n[3], n[4], n[5], n[6]);
  s.view.distance = n[7];
  s.view.fov = n[8];
  s.up = {n[9], n[10], n[11]};
  return s;
}

class Page {
 public:
  Page() : presenter_(make_web_screen()) {
    presenter_.viewer().sort_by([](const std::vector<glm::vec3>& positions) {
      return std::make_unique<WorkerSort>(positions);
    });
  }

  viewer::Viewer& viewer() { return presenter_.viewer(); }
  viewer::Presenter& presenter() { return presenter_; }

  void* room_for(const SceneHead& head) {
    coming_ = scene_with(head);
    blocks_ = blocks_of(*coming_);
    return blocks_.data();
  }

  /// Shows the scene that was written, from a view if one is given.
  void show(const std::optional<viewer::SavedView>& saved) {
    const bool refines = is_coarse_ && viewer().has_scene() && !presenter_.has_failed();
    state_.dropped = coming_->dropped;
    state_.error.clear();
    is_coarse_ = coming_->is_coarse;
    ordered_ = kNone;
    auto cloud = std::make_shared<const render::RenderCloud>(std::move(coming_->cloud));
    if (refines)
      presenter_.refine(std::move(cloud));
    else
      presenter_.show(std::move(cloud), coming_->start, saved);
    coming_.reset();
  }
  void begin_another() { is_coarse_ = false; }

  /// Draws what changed. Whether another frame is wanted.
  bool frame(double seconds) {
    const double passed = last_ ? std::max(seconds - *last_, 0.0) : 0;
    last_ = seconds;
    const auto shown = presenter_.frame(passed);
    if (!shown) state_.error = shown.error().message();
    if (shown && *shown) check_projection();
    const bool rests = presenter_.at_rest();
    if (rests) last_.reset();  // what moves next begins then
    return !rests;
  }

  const char* state() {
    viewer::Viewer& v = viewer();
    state_.stats = v.stats();
    state_.has_scene = v.has_scene() && !presenter_.has_failed();
    // The first frames wait for an order of the splats; later ones have one of some frames before
    if (presenter_.has_drawn() && v.is_open() && v.scene().renderer().order_is_current())
      ordered_ = presenter_.contexts();
    state_.drawn = presenter_.has_drawn() && v.is_open() && ordered_ == presenter_.contexts();
    state_.coarse = is_coarse_;
    state_.flipped = v.is_flipped();
    state_.motion = v.motion();
    state_.contexts = presenter_.contexts();
    json_ = viewer::to_json(state_);
    return json_.c_str();
  }

  std::optional<Image<std::uint8_t>> image;  // that was read last
  ViewNumbers view{};

 private:
  /// Compares where the first frame of a context put some splats with where they belong: some
  /// drivers' fragments are not exact enough, and then vertices project.
  void check_projection() {
    viewer::Viewer& v = viewer();
    if (checked_ == presenter_.contexts() || !v.scene().shows_all()) return;
    checked_ = presenter_.contexts();
    constexpr std::uint32_t kSome = 2048;
    const render::Renderer* const renderer = v.scene().renderer().gl_renderer();
    if (renderer == nullptr) return;
    const render::ImageSize size = v.scene().image_size();
    const camera::Navigation& n = v.navigation();
    const Camera camera = camera::camera_of(n.view, size.width, size.height);
    const auto found =
        bench::check_projection(*renderer, v.cloud().base,
                                render::scaled_camera(camera, size.blend_width, size.blend_height),
                                n.units.near_plane, kSome);
    if (found && !found->misplaces()) return;
    presenter_.screen().api()->quirks.fragment_projection_fails = true;
    v.close();  // the next frame makes it again
    presenter_.redraw();
  }

  viewer::Presenter presenter_;
  int checked_ = 0;  // the context whose projection was looked at
  std::optional<viewer::LoadedScene> coming_;
  std::array<Block, kBlocks> blocks_;
  bool is_coarse_ = false;
  static constexpr int kNone = -1;
  int ordered_ = kNone;  // the context that has drawn this scene's splats in their order
  std::optional<double> last_;
  viewer::SessionState state_;
  std::string json_;
};

Page& page() {
  static Page one;
  return one;
}

}  // namespace
}  // namespace fluxgs::web

using fluxgs::web::page;
using fluxgs::web::WorkerSort;
namespace viewer = fluxgs::viewer;

extern "C" {

/// The canvas, in pixels, and how many of them are a dp (1/160 inch).
EMSCRIPTEN_KEEPALIVE void flux_resize(int width, int height, double density) {
  page().presenter().resize(width, height, density);
}

/// Lets time pass, seconds on any clock, and draws what changed. Whether another frame is wanted.
EMSCRIPTEN_KEEPALIVE int flux_frame(double seconds) { return page().frame(seconds) ? 1 : 0; }

/// JSON, see session_json.h; its "loading" is the reader's.
EMSCRIPTEN_KEEPALIVE const char* flux_state() { return page().state(); }

/// Room for a scene of another instance, given its head: addresses and bytes of its blocks, which
/// the page writes. Null where there is no memory.
EMSCRIPTEN_KEEPALIVE void* flux_scene_room(const void* head) {
  try {
    return page().room_for(*static_cast<const fluxgs::web::SceneHead*>(head));
  } catch (const std::exception&) {
    return nullptr;
  }
}
/// They were written: shows the scene, or more of the same, from a view (kViewNumbers) unless that
/// is null.
EMSCRIPTEN_KEEPALIVE void flux_scene_show(const double* view) {
  page().show(view != nullptr ? std::optional(fluxgs::web::view_of(view)) : std::nullopt);
}
/// Another scene comes next, not more of the one before.
EMSCRIPTEN_KEEPALIVE void flux_scene_begin() { page().begin_another(); }

EMSCRIPTEN_KEEPALIVE void* flux_order_room(int scene, std::size_t count) {
  WorkerSort* const sort = WorkerSort::current();
  return sort != nullptr ? sort->room(scene, count) : nullptr;
}
EMSCRIPTEN_KEEPALIVE void flux_order_came(double ticket, std::uint32_t count) {
  WorkerSort::current()->came(static_cast<std::uint64_t>(ticket), count);
}

/// `scale` and `moving_scale` as in ViewerSettings; `memory` of the GPU in bytes, 0: all there is.
EMSCRIPTEN_KEEPALIVE void flux_set(double scale, double moving_scale, int sh_degree,
                                   double max_splats, double memory, double frame_seconds,
                                   double red, double green, double blue) {
  viewer::ViewerSettings s = page().viewer().settings();
  s.scale = scale;
  s.moving_scale = moving_scale;
  s.sh_degree = sh_degree;
  s.max_splats = static_cast<std::size_t>(max_splats);
  s.memory = memory > 0 ? std::optional(static_cast<std::size_t>(memory)) : std::nullopt;
  s.frame_seconds = frame_seconds;
  s.background = {red, green, blue};
  page().viewer().set(s);
  page().presenter().redraw();
}

/// TouchPhase, the finger that changed, and all fingers: id, x, y of each, px of the canvas.
EMSCRIPTEN_KEEPALIVE void flux_touch(int phase, int changed, const double* fingers, int count,
                                     double seconds) {
  std::vector<viewer::Finger> all;
  for (const double* f = fingers; f != fingers + 3 * std::ptrdiff_t{count}; f += 3)
    all.push_back({static_cast<int>(f[0]), {f[1], f[2]}});
  page().viewer().touch({static_cast<viewer::TouchPhase>(phase), changed, all, seconds});
}
/// WindowEvent of a mouse or a keyboard.
EMSCRIPTEN_KEEPALIVE void flux_event(int kind, double x, double y, int button, int down,
                                     double amount, int key, double seconds) {
  page().viewer().handle({.kind = static_cast<viewer::WindowEvent::Kind>(kind),
                          .position = {x, y},
                          .button = static_cast<viewer::PointerButton>(button),
                          .down = down != 0,
                          .amount = amount,
                          .key = static_cast<char>(key)},
                         seconds);
}

EMSCRIPTEN_KEEPALIVE void flux_reset_view() { page().viewer().reset_view(); }
EMSCRIPTEN_KEEPALIVE void flux_flip_up() { page().viewer().flip_up(); }
EMSCRIPTEN_KEEPALIVE void flux_drift(int on) { page().viewer().drift(on != 0); }
EMSCRIPTEN_KEEPALIVE void flux_walk(int on) { page().viewer().walk(on != 0); }
/// Draws with the next frame whether anything changed or not.
EMSCRIPTEN_KEEPALIVE void flux_redraw() { page().presenter().redraw(); }
/// The browser has taken the context away, and has given it back.
EMSCRIPTEN_KEEPALIVE void flux_lose_context() { page().presenter().lose_context(); }

/// The present view: kViewNumbers numbers; null before there is one.
EMSCRIPTEN_KEEPALIVE const double* flux_view() {
  const auto saved = page().viewer().saved_view();
  if (!saved) return nullptr;
  page().view = fluxgs::web::numbers_of(*saved);
  return page().view.data();
}
/// Room for the numbers of a view, for the functions that take one.
EMSCRIPTEN_KEEPALIVE double* flux_view_room() { return page().view.data(); }
/// Goes there smoothly, if the numbers are a view.
EMSCRIPTEN_KEEPALIVE void flux_go_to(const double* view) {
  page().viewer().go_to(fluxgs::web::view_of(view));
}

/// Reads the image of the present view, see Presenter::image(): RGBA, top row first. Null where
/// there is none.
EMSCRIPTEN_KEEPALIVE const void* flux_image(int longest) {
  auto& image = page().image = page().presenter().image(longest);
  if (!image) return nullptr;
  // Opaque: the background is behind the splats, and alpha is a by-product of blending
  for (std::size_t i = 3; i < image->pixels.size(); i += 4) image->pixels[i] = 0xFF;
  return image->pixels.data();
}
EMSCRIPTEN_KEEPALIVE int flux_image_width() { return page().image ? page().image->width : 0; }
EMSCRIPTEN_KEEPALIVE int flux_image_height() { return page().image ? page().image->height : 0; }
EMSCRIPTEN_KEEPALIVE void flux_image_drop() { page().image.reset(); }
}
