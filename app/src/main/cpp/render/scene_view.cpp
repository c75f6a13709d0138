#include "render/scene_view.h"

#include <algorithm>
#include <string>

#include "gl/steps.h"
#include "render/splat_budget.h"

namespace fluxgs::render {

Expected<void> SceneView::open(gl::Api& api, int width, int height) {
  close();
  api_ = &api;
  return gl::in_turn([&] { return gl::take(Renderer::create(api, settings_.renderer), renderer_); },
                     [&] { return fit(width, height); }, [&] { return check_context(); });
}

Expected<void> SceneView::check_context() const {
  if (!gl::context_lost(*api_)) return {};
  return fail("OpenGL", "", "the context was lost");
}

void SceneView::close() {
  target_ = {};
  renderer_.reset();
  shown_ = 0;
}

Expected<void> SceneView::draw(const Camera& camera, const RenderOptions& options) {
  if (camera.width != target_.width() || camera.height != target_.height()) {
    if (auto fitted = fit(camera.width, camera.height); !fitted) return fitted;
  }
  if (auto drawn = renderer_->draw(camera, options, target_); !drawn) return drawn;
  return check_context();
}

TargetPlan SceneView::plan(int width, int height) const {
  return {
      .width = width,
      .height = height,
      .format = settings_.format,
      .accumulation = settings_.accumulation.value_or(accurate_accumulation(api_->capabilities)),
      .scale = settings_.scale};
}

// By the estimate and the driver's limits; whether the driver has as much is seen when it is asked.
Expected<std::size_t> SceneView::splats_for(int width, int height) const {
  const int degree = cloud_->sh_degree;
  const std::uint64_t most = most_splats(api_->capabilities, degree);
  const std::size_t splats = std::min<std::size_t>(most, cloud_->size());
  if (!settings_.memory) return splats;
  const RendererSettings& renderer = renderer_->settings();
  const TargetPlan picture = plan(width, height);
  const std::uint64_t fitting = splats_that_fit(*settings_.memory, degree, renderer, picture);
  if (fitting > 0 || splats == 0) return std::min<std::size_t>(fitting, splats);
  const std::size_t needed = estimate_memory(1, degree, renderer, picture).total();
  return fail("graphics memory", "",
              "a picture of " + std::to_string(width) + "×" + std::to_string(height) +
                  " pixels with one splat takes " + std::to_string(needed) + " bytes; " +
                  std::to_string(*settings_.memory) + " may be used");
}

Expected<void> SceneView::upload(std::size_t splats) {
  if (splats == shown_) return {};
  shown_ = 0;
  auto uploaded = splats == cloud_->size()
                      ? renderer_->upload(*cloud_)
                      : renderer_->upload(in_order(*cloud_, most_contributing(*cloud_, splats)));
  if (uploaded) shown_ = splats;
  return uploaded;
}

Expected<void> SceneView::make(int width, int height, std::size_t splats) {
  // What is there goes first: there may not be room for both
  target_ = {};
  if (splats != shown_) {
    shown_ = 0;
    if (auto emptied = renderer_->upload({}); !emptied) return emptied;
  }
  const TargetPlan p = plan(width, height);
  return gl::in_turn(
      [&] {
        return gl::take(
            RenderTarget::create(*api_, width, height, p.format, p.accumulation, p.scale), target_);
      },
      [&] { return upload(splats); });
}

Expected<void> SceneView::fit(int width, int height) {
  const auto allowed = splats_for(width, height);
  if (!allowed) return std::unexpected(allowed.error());
  for (std::size_t splats = *allowed;; splats -= (splats + 3) / 4) {
    api_->out_of_memory = false;
    auto made = make(width, height, splats);
    if (made) return made;
    target_ = {};  // The next frame tries again
    if (gl::context_lost(*api_) || !api_->out_of_memory || splats <= 1) return made;
  }
}

}  // namespace fluxgs::render
