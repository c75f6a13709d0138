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

TargetPlan SceneView::plan(const Size& size) const {
  return {
      .width = size.width,
      .height = size.height,
      .format = settings_.format,
      .accumulation = settings_.accumulation.value_or(accurate_accumulation(api_->capabilities)),
      .scale = settings_.scale};
}

// By the estimate and the driver's limits; whether the driver has as much is seen when it is asked.
Expected<SceneView::Size> SceneView::picture_for(Size size) const {
  const gl::Capabilities& driver = api_->capabilities;
  const auto possible = [&] {
    const bool small = size.width <= std::min(driver.max_texture_size, driver.max_viewport_width) &&
                       size.height <= std::min(driver.max_texture_size, driver.max_viewport_height);
    const auto pixels = [&] { return estimate_memory({}, {}, plan(size)).targets; };
    return small && (!settings_.memory || (pixels() <= *settings_.memory / 2 &&
                                           (splats_for(size) > 0 || cloud_->size() == 0)));
  };
  while (!possible()) {
    if (size.is_pixel()) {
      return fail("graphics memory", "",
                  std::to_string(*settings_.memory) + " bytes do not hold one pixel and one splat");
    }
    size = size.halved();
  }
  return size;
}

std::size_t SceneView::splats_for(const Size& picture) const {
  std::uint64_t most = most_splats(api_->capabilities, degrees_);
  if (settings_.most_splats) most = std::min<std::uint64_t>(most, *settings_.most_splats);
  if (settings_.memory) {
    most = std::min(
        most, splats_that_fit(*settings_.memory, degrees_, renderer_->settings(), plan(picture)));
  }
  return most;
}

std::size_t SceneView::memory() const {
  const Size picture{target_.width(), target_.height()};
  return estimate_memory(largest_of(degrees_, shown_), renderer_->settings(), plan(picture))
      .total();
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

Expected<void> SceneView::make(const Size& picture, std::size_t splats) {
  // What is there goes first: there may not be room for both
  target_ = {};
  if (splats != shown_) {
    shown_ = 0;
    if (auto emptied = renderer_->upload({}); !emptied) return emptied;
  }
  const TargetPlan p = plan(picture);
  return gl::in_turn(
      [&] {
        return gl::take(
            RenderTarget::create(*api_, p.width, p.height, p.format, p.accumulation, p.scale),
            target_);
      },
      [&] { return upload(splats); },
      // Some drivers notice late
      [&] { return gl::check_errors(*api_, "graphics memory"); });
}

// As many splats as there is room for beside a picture of that size.
Expected<void> SceneView::fit_splats(const Size& picture) {
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
    if (made || !api_->out_of_memory || picture->is_pixel() || gl::context_lost(*api_)) return made;
    picture = picture->halved();
  }
}

}  // namespace fluxgs::render
