#include "viewer/viewer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "camera/focus.h"
#include "camera/initial_view.h"

namespace fluxgs::viewer {
namespace {

constexpr double kStatsSmoothing = 0.1;
constexpr double kRest = 0.25;  // seconds without movement: less is a finger that hesitates

using Seconds = std::chrono::duration<double>;

double seconds_between(std::chrono::steady_clock::time_point from,
                       std::chrono::steady_clock::time_point to) {
  return Seconds(to - from).count();
}

void smooth(double& mean, double value) {
  mean = mean > 0 ? std::lerp(mean, value, kStatsSmoothing) : value;
}

bool same(const camera::ViewState& a, const camera::ViewState& b) {
  return a.target == b.target && a.orientation == b.orientation && a.distance == b.distance &&
         a.fov == b.fov;
}

}  // namespace

void Viewer::show(std::shared_ptr<const render::RenderCloud> cloud,
                  const std::optional<InitialView>& initial,
                  const std::optional<SavedView>& saved) {
  close();
  cloud_ = std::move(cloud);
  initial_ = initial;
  saved_ = saved;
  navigated_ = false;
  stats_ = {};
  anchor_anew(gyroscope_);
}

void Viewer::show(std::shared_ptr<const render::RenderCloud> cloud,
                  const camera::Navigation& navigation) {
  show(std::move(cloud), std::nullopt);
  navigation_ = navigation;
  first_up_ = navigation.up;
  navigated_ = true;
}

void Viewer::refine(std::shared_ptr<const render::RenderCloud> cloud) {
  cloud_ = std::move(cloud);
  remake_ = stale_ = true;
  if (!navigated_) return;
  const camera::Navigation whole =
      camera::initial_navigation(cloud_->base, initial_, glm::dvec2(size_));
  navigation_.units = whole.units;
  if (!initial_ || is_flipped()) return;
  // The same eye looks the same way, but at what is seen now
  const bool is_home = same(navigation_.view, navigation_.home);
  camera::ViewState& home = navigation_.home;
  const double fov = std::exchange(home, whole.home).fov;
  home.fov = fov;
  if (is_home) navigation_.view = home;
}

// Needs to know how large the image is.
void Viewer::begin_navigation() {
  if (navigated_ || !cloud_) return;
  navigation_ = camera::initial_navigation(cloud_->base, initial_, glm::dvec2(size_));
  first_up_ = navigation_.up;
  navigated_ = true;
  const auto saved = saved_ ? restored(*saved_) : std::nullopt;
  if (!saved) return;
  take_up_of(*saved);
  navigation_.view = saved->view;
}

/// What is up in a saved view is up in the scene.
void Viewer::take_up_of(const SavedView& saved) {
  if (glm::dot(saved.up, navigation_.up) < 0) camera::flip_up(navigation_);
  navigation_.up = saved.up;
}

render::SceneViewSettings Viewer::scene_settings() const {
  using render::SorterKind;
  const gl::Quirks& quirks = device_->quirks();
  render::SceneViewSettings s{
      .renderer = {.timestamps = true, .approximation = render::default_approximation(quirks)}};
  const bool on_cpu = settings_.sorter == SorterChoice::cpu || quirks.gpu_sort_fails ||
                      (settings_.sorter == SorterChoice::automatic && quirks.runs_on_cpu);
  s.renderer.sorter = on_cpu ? SorterKind::cpu_async : SorterKind::gpu_radix;
  s.renderer.background_sort = background_sort_;
  s.memory = settings_.memory;
  if (settings_.max_splats > 0) s.max_splats = settings_.max_splats;
  s.scale = wanted_detail().scale;
  if (make_software_) s.software = make_software_(cloud_);
  return s;
}

Expected<void> Viewer::make() {
  scene_.emplace(cloud_, scene_settings());
  auto opened = scene_->open(*device_, size_.x, size_.y);
  if (!opened) scene_.reset();
  stale_ = true;
  remake_ = false;
  detail_.reset();
  return opened;
}

Expected<void> Viewer::open(render::Device& device, int width, int height) {
  if (!cloud_) return fail("viewer", "", "there is no scene to open");
  device_ = &device;
  size_ = {std::max(width, 1), std::max(height, 1)};
  begin_navigation();
  return make();
}

void Viewer::close() {
  scene_.reset();
  presented_.reset();
}

/// True if graphics objects were made for other settings.
bool Viewer::needs_remaking(const ViewerSettings& s) const {
  const bool fits =
      is_open() && !scene_->is_reduced() && (!s.memory || scene_->memory() <= *s.memory);
  return s.sorter != settings_.sorter || s.max_splats != settings_.max_splats ||
         (s.memory != settings_.memory && !fits);
}

void Viewer::set(const ViewerSettings& settings) {
  if (settings == settings_) return;
  remake_ = remake_ || needs_remaking(settings);
  if (settings.gyroscope != settings_.gyroscope) {
    anchor_anew(gyroscope_);
    drift(false);
  }
  settings_ = settings;
  goal_.set_display(settings.frame_seconds);
  goal_.set_most(settings.moving_scale);
  stale_ = true;
}

void Viewer::set_heat(const Heat& heat) { goal_.set_heat(heat); }

void Viewer::resize(int width, int height, double density) {
  if (std::isfinite(density) && density > 0) gestures_.options.density = density;
  const glm::ivec2 size(std::max(width, 1), std::max(height, 1));
  if (size == size_) return;
  size_ = size;
  stale_ = true;
  presented_.reset();
}

/// Lets an input move the view, and looks at the pixel that it returns, if any.
template <class Input>
void Viewer::steer(Input&& input) {
  if (!navigated_) return;
  const camera::ViewState before = navigation_.view;
  const std::optional<glm::dvec2> pixel = input();
  camera::keep_on_foot(navigation_);
  if (!same(before, navigation_.view)) {
    anchor_anew(gyroscope_);
    stale_ = true;
  }
  if (!pixel) return;
  const camera::Navigation& n = navigation_;
  const auto point =
      camera::visible_point(cloud_->base, n.view, *pixel, glm::dvec2(size_), n.units.near_plane);
  if (point) camera::go_to(navigation_, camera::focused_on(n.view, *point, n.units.distances));
}

void Viewer::touch(const TouchEvent& event) {
  const bool looks = settings_.gyroscope || navigation_.walking;
  gestures_.one_finger = looks ? camera::DragAction::look : camera::DragAction::orbit;
  steer([&] { return apply(event, glm::dvec2(size_), gestures_, navigation_); });
}

void Viewer::handle(const WindowEvent& event, double seconds) {
  steer([&] { return apply(event, seconds, glm::dvec2(size_), mouse_and_keys_, navigation_); });
}

void Viewer::turn(const DevicePose& pose) {
  if (!navigated_ || !settings_.gyroscope || !gestures_.fingers.empty()) return;
  if (camera::moving_by_itself(navigation_)) return anchor_anew(gyroscope_);
  const camera::ViewState before = navigation_.view;
  follow(pose, gyroscope_, navigation_);
  // Sensors tremble; what nobody sees is not drawn
  constexpr double kStill = 2e-8;  // 1 − cos of half of 0.023°
  if (1 - std::abs(glm::dot(before.orientation, navigation_.view.orientation)) < kStill) {
    navigation_.view = before;
    return;
  }
  stale_ = true;
}

void Viewer::flip_up() {
  if (!navigated_) return;
  camera::flip_up(navigation_);
  anchor_anew(gyroscope_);
  stale_ = true;
}

bool Viewer::is_flipped() const { return navigated_ && glm::dot(navigation_.up, first_up_) < 0; }

void Viewer::reset_view() {
  if (!navigated_) return;
  camera::reset(navigation_);
  anchor_anew(gyroscope_);
}

void Viewer::drift(bool on) {
  if (!navigated_ || !gestures_.fingers.empty()) return;
  if (on)
    camera::drift(navigation_);
  else
    navigation_.drift.reset();
}

void Viewer::play(std::shared_ptr<const camera::CameraPath> path) {
  if (!navigated_) return;
  if (path)
    camera::play(navigation_, std::move(path), glm::dvec2(size_));
  else
    navigation_.playback.reset();
}

void Viewer::go_to(const SavedView& saved) {
  const auto sound = restored(saved);
  if (!navigated_ || !sound) return;
  const camera::ViewState from = navigation_.view;
  camera::stop_walking(navigation_);
  take_up_of(*sound);
  navigation_.view = from;
  camera::go_to(navigation_, sound->view);
}

void Viewer::walk(bool on) {
  if (!navigated_) return;
  if (on)
    camera::start_walking(navigation_);
  else
    camera::stop_walking(navigation_);
}

void Viewer::stick(double right, double ahead) {
  if (!navigation_.walking || !std::isfinite(right) || !std::isfinite(ahead)) return;
  navigation_.flying = {.right = std::clamp(right, -1.0, 1.0),
                        .forward = std::clamp(ahead, -1.0, 1.0)};
}

Motion Viewer::motion() const {
  if (navigation_.walking) return Motion::walk;
  if (navigation_.playback) return Motion::path;
  return navigation_.drift ? Motion::drift : Motion::none;
}

std::optional<SavedView> Viewer::saved_view() const {
  if (!navigated_) return saved_;
  return SavedView{navigation_.view, navigation_.up};
}

bool Viewer::advance(double seconds) {
  if (!is_open()) return false;
  constexpr double kLongestStep = 0.1;  // after a pause the scene must not jump
  const bool moved =
      camera::advance(navigation_, std::min(seconds, kLongestStep), glm::dvec2(size_));
  stale_ = stale_ || moved;
  if (stale_ || !scene_->renderer().order_is_current()) {
    still_ = 0;
    return true;
  }
  presented_.reset();
  still_ += std::min(seconds, kLongestStep);
  if (!rests()) return false;
  goal_.pause();
  frame_seconds_ = 0;
  return detail_ != wanted_detail();
}

bool Viewer::rests() const { return still_ >= kRest; }

bool Viewer::at_rest() const {
  return is_open() && rests() && !stale_ && !camera::moving(navigation_) &&
         detail_ == wanted_detail() && scene_->renderer().order_is_current();
}

/// There is time for all pixels and splats when nothing moves.
Detail Viewer::wanted_detail() const {
  if (settings_.scale > 0) return {.scale = settings_.scale};
  return rests() ? Detail{.scale = goal_.coolest()} : goal_.detail();
}

Expected<void> Viewer::set_detail(const Detail& detail) {
  scene_->set_scale(detail.scale);
  render::SceneRenderer& renderer = scene_->renderer();
  render::ApproximationSettings approximation = renderer.settings().approximation;
  approximation.min_weight = detail.min_weight;
  return renderer.set_approximation(approximation);
}

RenderOptions Viewer::render_options() const {
  RenderOptions options;
  options.sh_degree = settings_.sh_degree;
  options.near_plane = navigation_.units.near_plane;
  options.background = settings_.background;
  return options;
}

Expected<void> Viewer::draw_exact(const camera::ViewState& view, int width, int height) {
  if (!is_open()) return fail("viewer", "", "the scene is no longer shown");
  stale_ = true;  // the window shows another view
  if (auto set = set_detail({}); !set) return set;
  scene_->renderer().wait_for_sorts(true);
  scene_->renderer().measure(false);
  return scene_->draw(camera::camera_of(view, width, height), render_options());
}

Expected<void> Viewer::draw() {
  if (remake_) {
    scene_.reset();
    if (auto made = make(); !made) return made;
  }
  const Detail detail = wanted_detail();
  if (auto set = set_detail(detail); !set) return set;
  const Camera camera = camera::camera_of(navigation_.view, size_.x, size_.y);
  scene_->renderer().wait_for_sorts(settings_.wait_for_sorts);
  scene_->renderer().measure(settings_.measures);
  auto drawn = scene_->draw(camera, render_options());
  if (!drawn) return drawn;
  stale_ = false;
  detail_ = detail;
  measurable_ = true;
  return {};
}

Expected<void> Viewer::draw_sharp() {
  const double still = std::exchange(still_, kRest);
  auto drawn = draw();
  still_ = still;
  return drawn;
}

void Viewer::presented() {
  const auto now = Clock::now();
  if (presented_) {
    const double passed = seconds_between(*presented_, now);
    smooth(frame_seconds_, passed);
    goal_.frame(passed);
  }
  presented_ = now;
}

/// Takes what the GPU says of frames that it has finished; only the last image, once all is at
/// rest, is waited for.
void Viewer::measure() {
  if (!measurable_ || !settings_.measures) return;
  if (const auto drawn = scene_->drawn_in_software()) {
    stats_.drawn = *drawn;
    stats_.frame_ms = 1e3 * frame_seconds_;
    return;
  }
  render::SceneRenderer& renderer = scene_->renderer();
  std::optional<render::FrameStats> frame;
  if (rests()) {
    if (auto last = renderer.stats()) frame = *last;
    measurable_ = !frame;
  } else if (auto finished = renderer.finished_stats()) {
    frame = *finished;
  }
  if (!frame) return;
  stats_.drawn = frame->drawn;
  const bool has_clock = frame->stages.has_value();
  const render::FrameTimes stages = frame->stages.value_or(render::FrameTimes());
  stats_.draw_ms = stages.project + stages.draw + stages.resolve;
  if (has_clock)
    stats_.frame_ms = stats_.draw_ms + stages.sort;
  else if (frame_seconds_ > 0)
    stats_.frame_ms = 1e3 * frame_seconds_;
  const bool on_gpu = renderer.settings().sorter == render::SorterKind::gpu_radix;
  if (!on_gpu)
    stats_.sort_ms = 1e3 * renderer.sort_latency();
  else if (has_clock)
    stats_.sort_ms = stages.sort;
}

ViewerStats Viewer::stats() {
  if (!is_open()) return {};
  measure();
  stats_.frames_per_second = frame_seconds_ > 0 ? 1 / frame_seconds_ : 0;
  stats_.goal = 1 / goal_.seconds();
  stats_.shown = scene_->splats();
  stats_.splats = cloud_->file_splats;
  stats_.sh_degree = scene_->sh_degree();
  stats_.file_sh_degree = cloud_->file_sh_degree;
  stats_.reduced = scene_->is_reduced();
  const render::ImageSize image = scene_->image_size();
  stats_.image = static_cast<double>(image.width) / size_.x;
  stats_.coolest = settings_.scale > 0 ? 1 : goal_.coolest();
  stats_.memory = scene_->memory();
  stats_.width = image.blend_width;
  stats_.height = image.blend_height;
  stats_.scale = detail_.value_or(wanted_detail()).scale;
  return stats_;
}

}  // namespace fluxgs::viewer
