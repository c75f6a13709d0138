#include "render/scene_view.h"

#include <algorithm>
#include <string>

#include "gl/steps.h"
#include "render/scaled_camera.h"
#include "render/scene_buffers.h"
#include "render/splat_budget.h"

namespace fluxgs::render {

Expected<void> SceneView::open(gl::Api& api, int width, int height) {
  close();
  api_ = &api;
  if (auto sound = check_cloud(*cloud_); !sound) return sound;
  degrees_ = count_degrees(*cloud_);
  return gl::in_turn([&] { return gl::take(Renderer::create(api, settings_.renderer), renderer_); },
                     [&] { return fit({width, height}); }, [&] { return check_context(); });
}

Expected<void> SceneView::check_context() const {
  if (!gl::context_lost(*api_)) return {};
  return fail("OpenGL", "", "the context was lost");
}

void SceneView::set_scale(double scale) {
  if (scale == settings_.scale) return;
  settings_.scale = scale;
  fitted_ = {};
}

void SceneView::close() {
  target_ = {};
  planned_ = {};
  fitted_ = {};
  renderer_.reset();
  shown_ = 0;
}

Expected<void> SceneView::draw(const Camera& camera, const RenderOptions& options) {
  if (auto ok = check_view(camera, options); !ok) return ok;
  const Size size{camera.width, camera.height};
  if (size != fitted_)
    if (auto fitted = fit(size); !fitted) return fitted;
  const Camera view = scaled_camera(camera, target_.width(), target_.height());
  if (auto drawn = renderer_->draw(view, options, target_); !drawn) return drawn;
  auto whole = check_context();
  if (!whole) renderer_->sort_anew();  // who knows what became of the order
  return whole;
}

Accumulation SceneView::accurate() const {
  return settings_.accumulation.value_or(accurate_accumulation(api_->capabilities));
}

TargetPlan SceneView::plan(const Size& size, Accumulation accumulation) const {
  return {.width = size.width,
          .height = size.height,
          .format = settings_.format,
          .accumulation = accumulation,
          .scale = settings_.scale};
}

// By the estimate and the driver's limits; whether the driver has as much is seen when it is asked.
bool SceneView::is_possible(const TargetPlan& picture) const {
  const gl::Capabilities& driver = api_->capabilities;
  if (picture.width > std::min(driver.max_texture_size, driver.max_viewport_width) ||
      picture.height > std::min(driver.max_texture_size, driver.max_viewport_height))
    return false;
  if (!settings_.memory) return true;
  const auto all =
      estimate_memory(largest_of(degrees_, splats_asked()), renderer_->settings(), picture);
  return all.total() <= *settings_.memory ||
         (all.targets <= *settings_.memory / 2 && splats_for(picture) > 0);
}

Expected<TargetPlan> SceneView::picture_for(Size size) const {
  const bool halves = !settings_.accumulation && api_->capabilities.half_float_targets;
  for (;; size = size.halved()) {
    for (const Accumulation a : {accurate(), halves ? Accumulation::half_float : accurate()})
      if (const TargetPlan picture = plan(size, a); is_possible(picture)) return picture;
    if (size.is_pixel())
      return fail("graphics memory", "",
                  std::to_string(*settings_.memory) + " bytes do not hold one pixel and one splat");
  }
}

std::size_t SceneView::splats_asked() const {
  return std::min(settings_.most_splats.value_or(~0UL), cloud_->size());
}

std::size_t SceneView::splats_for(const TargetPlan& picture) const {
  std::uint64_t most =
      std::min<std::uint64_t>(most_splats(api_->capabilities, degrees_), splats_asked());
  if (settings_.memory)
    most = std::min(most,
                    splats_that_fit(*settings_.memory, degrees_, renderer_->settings(), picture));
  return most;
}

std::size_t SceneView::memory() const {
  return estimate_memory(largest_of(degrees_, shown_), renderer_->settings(), planned_).total();
}

bool SceneView::is_reduced() const {
  return shown_ < splats_asked() || Size{planned_.width, planned_.height} != fitted_ ||
         planned_.accumulation != accurate();
}

Expected<void> SceneView::upload(std::size_t splats) {
  if (splats == shown_) return {};
  shown_ = 0;
  auto uploaded = splats == cloud_->size()
                      ? renderer_->upload(*cloud_)
                      : renderer_->upload(*cloud_, most_contributing(*cloud_, splats));
  if (uploaded) shown_ = splats;
  return uploaded;
}

Expected<void> SceneView::make(const TargetPlan& picture, std::size_t splats) {
  // What is there goes first: there may not be room for both
  target_ = {};
  if (splats != shown_) {
    shown_ = 0;
    if (auto emptied = renderer_->upload({}); !emptied) return emptied;
  }
  planned_ = picture;
  return gl::in_turn(
      [&] {
        return gl::take(RenderTarget::create(*api_, picture.width, picture.height, picture.format,
                                             picture.accumulation, picture.scale),
                        target_);
      },
      [&] { return upload(splats); },
      // Some drivers notice late
      [&] { return gl::check_errors(*api_, "graphics memory"); });
}

// As many splats as there is room for beside that picture.
Expected<void> SceneView::fit_splats(const TargetPlan& picture) {
  for (std::size_t splats = splats_for(picture);; splats -= (splats + 3) / 4) {
    api_->out_of_memory = false;
    auto made = make(picture, splats);
    if (made || !api_->out_of_memory || splats <= 1) return made;
  }
}

Expected<void> SceneView::fit(const Size& size) {
  fitted_ = {};
  auto picture = picture_for(size);
  if (!picture) return std::unexpected(picture.error());
  for (;;) {
    auto made = fit_splats(*picture);
    if (made) fitted_ = size;
    const Size tried{picture->width, picture->height};
    if (made || !api_->out_of_memory || tried.is_pixel() || gl::context_lost(*api_)) return made;
    picture = plan(tried.halved(), picture->accumulation);
  }
}

}  // namespace fluxgs::render
