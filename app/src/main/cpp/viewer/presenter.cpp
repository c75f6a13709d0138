#include "viewer/presenter.h"

namespace fluxgs::viewer {

void Presenter::set_limits(const render::DriverLimits& limits) {
  if (limits == limits_) return;
  limits_ = limits;
  lose_context();
}

void Presenter::attach(void* window, std::uint64_t number) {
  screen_->attach(window);
  gate_.use(number);
  failed_ = false;
  redraw_ = true;
}

void Presenter::resize(int width, int height, double density) {
  width_ = width;
  height_ = height;
  viewer_.resize(width, height, density);
}

bool Presenter::can_draw() const {
  return viewer_.has_scene() && !failed_ && screen_->has_window() && width_ >= 1 && height_ >= 1;
}

bool Presenter::at_rest() const { return !can_draw() || (!redraw_ && viewer_.at_rest()); }

Expected<render::Device*> Presenter::device() {
  render::Device* const device = screen_->device();
  if (device != nullptr && !device->is_lost()) return device;
  viewer_.close();
  auto made = screen_->make_device();
  if (!made) return made;
  ++contexts_;
  if (gl::Api* const api = screen_->api()) render::apply(limits_, *api);
  return made;
}

Expected<bool> Presenter::draw() {
  const auto made = device();
  if (!made) return std::unexpected(made.error());
  if (!viewer_.is_open())
    if (auto opened = viewer_.open(**made, width_, height_); !opened)
      return std::unexpected(opened.error());
  if (auto drawn = viewer_.draw(); !drawn) return std::unexpected(drawn.error());
  return gate_.draw_or(Expected<bool>(false), [&] {
    return screen_->present([this] { viewer_.scene().show(width_, height_); }, width_, height_);
  });
}

Expected<bool> Presenter::frame(double seconds) {
  if (!can_draw()) return false;
  const bool moves = viewer_.advance(seconds);
  if (!moves && !redraw_ && viewer_.is_open()) return false;
  constexpr int kMaxLosses = 3;  // of contexts one after the other, without an image between
  Expected<bool> shown = draw();
  for (int losses = 0; !shown && losses < kMaxLosses; ++losses) {
    render::Device* const device = screen_->device();
    if (device == nullptr || !device->is_lost()) break;
    shown = draw();
  }
  if (!shown) {
    give_up();
    return shown;
  }
  redraw_ = !*shown;
  if (!*shown) return false;
  viewer_.presented();
  drawn_ = true;
  return true;
}

void Presenter::give_up() {
  failed_ = true;
  viewer_.close();
}

void Presenter::lose_context() {
  if (render::Device* const device = screen_->device()) device->lose();
  redraw_ = true;
}

Expected<void> Presenter::begin_video(void* window) {
  const auto made = device();
  if (auto begun = screen_->begin_video(window); !begun) return begun;  // has the window now
  if (!made) return std::unexpected(made.error());
  return viewer_.is_open() ? Expected<void>() : viewer_.open(**made, width_, height_);
}

Expected<void> Presenter::video_frame(const camera::ViewState& view, const VideoPlan& plan,
                                      std::int64_t nanoseconds) {
  if (auto drawn = viewer_.draw_exact(view, plan.width, plan.height); !drawn) return drawn;
  return screen_->video_frame([&] { viewer_.scene().show(plan.width, plan.height); }, nanoseconds);
}

void Presenter::end_video() {
  screen_->end_video();
  redraw_ = true;
}

std::optional<Image<std::uint8_t>> Presenter::image(int longest) {
  if (!viewer_.is_open() || !drawn_) return std::nullopt;
  if (longest == 0) {
    redraw_ = true;  // on the window, too
    if (!viewer_.draw_sharp()) return std::nullopt;
  }
  auto read = viewer_.scene().read(longest);
  if (!read) return std::nullopt;
  return std::move(*read);
}

}  // namespace fluxgs::viewer
