#include "render/gl_device.h"

#include <algorithm>
#include <utility>

#include "gl/expected_chain.h"
#include "render/render_target.h"
#include "render/renderer.h"
#include "render/scene_buffers.h"

namespace fluxgs::render {
namespace {

class GlSceneRenderer final : public SceneRenderer {
 public:
  GlSceneRenderer(gl::Api& api, std::unique_ptr<Renderer> renderer)
      : api_(api), renderer_(std::move(renderer)) {}

  const RendererSettings& settings() const override { return renderer_->settings(); }
  Expected<void> set_approximation(const ApproximationSettings& approximation) override {
    return renderer_->set_approximation(approximation);
  }
  void wait_for_sorts(bool wait) override { renderer_->wait_for_sorts(wait); }
  void measure(bool on) override { renderer_->measure(on); }

  Expected<void> upload(const RenderCloud& cloud,
                        std::optional<std::span<const std::uint32_t>> splats,
                        int max_sh_degree) override {
    return renderer_->upload(cloud, splats, max_sh_degree);
  }
  std::size_t undrawable() const override { return renderer_->undrawable(); }

  Expected<void> make_image(const TargetPlan& plan) override {
    target_ = {};
    return gl::assign_or_error(
        RenderTarget::create_for_window(api_, plan.width, plan.height, plan.accumulation), target_);
  }
  void drop_image() override { target_ = {}; }
  ImageSize image_size() const override {
    return {target_.width(), target_.height(), target_.blend_width(), target_.blend_height()};
  }
  void set_scale(double scale) override { target_.set_scale(scale); }

  Expected<void> draw(const Camera& camera, const RenderOptions& options) override {
    return renderer_->draw(camera, options, target_);
  }
  void fill(const Image<std::uint8_t>& image) override { target_.fill(api_, image); }
  void show(int width, int height) const override { renderer_->show(target_, width, height); }
  Expected<Image<std::uint8_t>> read(int longest) const override {
    return renderer_->read_shown(target_, longest);
  }

  bool order_is_current() const override { return renderer_->order_is_current(); }
  void sort_anew() override { renderer_->sort_anew(); }
  double sort_latency() const override { return renderer_->sort_latency(); }
  Expected<FrameStats> stats() override { return renderer_->stats(); }
  Expected<std::optional<FrameStats>> finished_stats() override {
    return renderer_->finished_stats();
  }
  const Renderer* gl_renderer() const override { return renderer_.get(); }

 private:
  gl::Api& api_;
  std::unique_ptr<Renderer> renderer_;
  RenderTarget target_;
};

}  // namespace

std::vector<Accumulation> GlDevice::accumulations() const {
  const Accumulation first = default_accumulation(api_);
  if (first != Accumulation::single_float || !api_.capabilities.half_float_targets) return {first};
  return {first, Accumulation::half_float};
}

int GlDevice::max_image_width() const {
  return std::min(api_.capabilities.max_texture_size, api_.capabilities.max_viewport_width);
}

int GlDevice::max_image_height() const {
  return std::min(api_.capabilities.max_texture_size, api_.capabilities.max_viewport_height);
}

std::uint64_t GlDevice::max_splats(const DegreeCounts& scene) const {
  return render::max_splats(api_.capabilities, scene);
}

Expected<std::unique_ptr<SceneRenderer>> GlDevice::make_renderer(const RendererSettings& settings) {
  auto made = Renderer::create(api_, settings);
  if (!made) return std::unexpected(made.error());
  return std::make_unique<GlSceneRenderer>(api_, std::move(*made));
}

}  // namespace fluxgs::render
