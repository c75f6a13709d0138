#include "render/renderer.h"

#include <span>
#include <string>

#include "gl/steps.h"
#include "sort/gpu_radix_sorter.h"

namespace fluxgs::render {

Expected<std::unique_ptr<Renderer>> Renderer::create(gl::Api& api,
                                                     const RendererSettings& settings) {
  if (auto ok = gl::check_limits(api.capabilities); !ok) return std::unexpected(ok.error());
  std::unique_ptr<Renderer> renderer(new Renderer(api, settings));
  if (auto ok = renderer->create_passes(); !ok) return std::unexpected(ok.error());
  return renderer;
}

Expected<void> Renderer::create_passes() {
  settings_.timestamps = settings_.timestamps && api_.capabilities.timestamps;
  if (settings_.timestamps)
    for (gl::Timestamp& stamp : stamps_) stamp = gl::Timestamp(api_);
  constexpr std::size_t kUniformBytes = sizeof(FrameUniforms);
  return gl::in_turn(
      [&] { return gl::take(ProjectionPass::create(api_), projection_); },
      [&] {
        return gl::take(sort::GpuRadixSorter::create(api_, settings_.sort_digit_bits), sorter_);
      },
      [&] { return gl::take(DrawPass::create(api_, settings_.batch), draw_); },
      [&] { return gl::take(ResolvePass::create(api_), resolve_); },
      [&] {
        return gl::take(gl::Buffer::create(api_, kUniformBytes, nullptr, GL_DYNAMIC_DRAW),
                        uniforms_);
      });
}

Expected<void> Renderer::upload(const SplatCloud& cloud) {
  auto scene = SceneBuffers::create(api_, cloud);
  if (!scene) return std::unexpected(scene.error());
  const auto spare = static_cast<std::uint32_t>(draw_.batch());
  auto room = gl::in_turn([&] { return projection_.reserve(api_, scene->count); },
                          [&] { return sorter_->reserve(scene->count, spare); });
  if (!room) {
    scene_ = {};  // The buffers may already have the new scene's size
    return room;
  }
  scene_ = std::move(*scene);
  drawn_ = false;
  return {};
}

void Renderer::set_uniforms(const Camera& camera, const RenderOptions& options) {
  const FrameUniforms values =
      make_frame_uniforms(camera, options, scene_.origin, scene_.count, scene_.sh_degree);
  uniforms_.write(0, std::as_bytes(std::span(&values, 1)));
  uniforms_.bind_base(GL_UNIFORM_BUFFER, 0);
}

void Renderer::stamp(int stage) const {
  if (settings_.timestamps) stamps_[static_cast<std::size_t>(stage)].record();
}

Expected<void> Renderer::draw(const Camera& camera, const RenderOptions& options,
                              const RenderTarget& target) {
  if (auto ok = check_view(camera, options); !ok) return ok;
  if (camera.width != target.width() || camera.height != target.height()) {
    return fail("camera", "size",
                std::to_string(camera.width) + "×" + std::to_string(camera.height) +
                    " pixels; the target has " + std::to_string(target.width()) + "×" +
                    std::to_string(target.height()));
  }
  stamp(0);
  if (scene_.count > 0) {
    set_uniforms(camera, options);
    projection_.run(api_, scene_);
    stamp(1);
    sorter_->sort(projection_.keys(), scene_.count);
    stamp(2);
    draw_.run(api_, projection_.records(), *sorter_, options.background, target);
  } else {
    stamp(1);
    stamp(2);
    clear(api_, options.background, target);
  }
  stamp(3);
  resolve_.run(api_, target);
  stamp(4);
  drawn_ = true;
  return {};
}

Expected<FrameStats> Renderer::stats() const {
  FrameStats stats;
  if (!drawn_) return stats;
  if (scene_.count > 0) {
    auto count = sorter_->count().read_all<std::uint32_t>(1);
    if (!count) return std::unexpected(count.error());
    stats.drawn = count->front();
  }
  if (settings_.timestamps) {
    const auto span = [&](std::size_t stage) {
      return 1e-6 *
             static_cast<double>(stamps_[stage + 1].nanoseconds() - stamps_[stage].nanoseconds());
    };
    stats.stages = StageTimes{span(0), span(1), span(2), span(3)};
  }
  return stats;
}

}  // namespace fluxgs::render
