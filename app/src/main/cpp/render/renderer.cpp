#include "render/renderer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "gl/expected_chain.h"
#include "render/compute_pipeline.h"
#include "render/fragment_pipeline.h"
#include "render/scaled_camera.h"
#include "render/scene_buffers.h"
#include "render/sort_view.h"
#include "render/view_check.h"
#include "sort/async_cpu_sorter.h"
#include "sort/exact_sorter.h"
#include "sort/gpu_radix_sorter.h"

namespace fluxgs::render {
Expected<std::unique_ptr<Renderer>> Renderer::create(gl::Api& api,
                                                     const RendererSettings& settings) {
  if (auto ok = gl::check_limits(api.capabilities); !ok) return std::unexpected(ok.error());
  std::unique_ptr<Renderer> renderer(new Renderer(api, settings));
  if (auto ok = renderer->create_passes(); !ok) return std::unexpected(ok.error());
  return renderer;
}

/// To what the driver has.
void Renderer::limit_settings() {
  const gl::Capabilities& driver = api_.capabilities;
  RendererSettings& s = settings_;
  s.timestamps = s.timestamps && driver.timestamps;
  s.compute = s.compute && driver.compute;
  s.project_in_vertices =
      !s.compute && (s.project_in_vertices || api_.quirks.fragment_projection_fails);
  s.texture_fetch = s.compute && (s.texture_fetch || driver.max_vertex_storage_blocks < 2);
  const bool can_mark = s.compute && driver.framebuffer_fetch && !s.texture_fetch &&
                        driver.max_vertex_storage_blocks >= 3;
  if (!can_mark) s.slices = 1;
  if (!s.compute && s.sorter == SorterKind::gpu_radix) s.sorter = SorterKind::cpu_async;
}

Expected<void> Renderer::create_passes() {
  if (auto ok = check_settings(settings_); !ok) return ok;
  limit_settings();
  constexpr std::size_t kUniformBytes = sizeof(FrameUniforms);
  return gl::chain(
      [&] { return gl::assign_or_error(FrameMeter::create(api_, settings_.timestamps), meter_); },
      [&] { return create_pipeline(); }, [&] { return create_sorter(); },
      [&] { return gl::assign_or_error(ResolvePass::create(api_), resolve_); },
      [&] {
        return gl::assign_or_error(
            gl::Buffer::create(api_, kUniformBytes, nullptr, GL_DYNAMIC_DRAW), uniforms_);
      });
}

Expected<void> Renderer::create_pipeline() {
  const bool computes = gl::kMayCompute && settings_.compute;
  return gl::assign_or_error(computes ? ComputePipeline::create(api_, settings_)
                                      : FragmentPipeline::create(api_, settings_),
                             pipeline_);
}

Expected<void> Renderer::create_sorter() {
  const auto keep = [&](auto made) -> Expected<void> {
    if (!made) return std::unexpected(made.error());
    sorter_ = std::move(*made);
    return {};
  };
  const auto place = settings_.compute ? sort::OrderPlace::buffers : sort::OrderPlace::texture;
  switch (settings_.sorter) {
    case SorterKind::gpu_radix:
      if (!gl::kMayCompute) break;
      return keep(sort::GpuRadixSorter::create(api_, settings_.sort_digit_bits));
    case SorterKind::cpu_async:
      return keep(sort::AsyncCpuSorter::create(api_, place, settings_.background_sort));
    case SorterKind::exact:
      return keep(sort::ExactSorter::create(api_, place));
  }
  return fail("renderer", "sorter", "unknown");
}

Expected<void> Renderer::set_approximation(const ApproximationSettings& approximation) {
  if (auto ok = check_approximation(approximation); !ok) return ok;
  settings_.approximation = approximation;
  return {};
}

Expected<void> Renderer::upload(const RenderCloud& cloud,
                                std::optional<std::span<const std::uint32_t>> splats,
                                int max_sh_degree) {
  if (auto ok = check_cloud(cloud); !ok) return ok;
  ScenePacker packer(cloud, splats, max_sh_degree);
  if (auto ok = check_size(api_.capabilities, packer.degrees()); !ok) return ok;
  scene_ = {};
  pipeline_->unload();  // There may not be room for both
  undrawable_ = packer.undrawable();
  sorted_.reset();
  meter_.clear();
  std::vector<glm::vec3> positions;
  const std::uint32_t count = packer.constants().count;
  const auto spare = static_cast<std::uint32_t>(settings_.batch);  // fill up the last instance
  auto loaded = gl::chain(
      [&] { return pipeline_->load(packer, sorter_->needs_positions() ? &positions : nullptr); },
      [&] { return sorter_->set_scene(count, spare, std::move(positions)); });
  if (!loaded) return loaded;
  scene_ = packer.constants();
  return {};
}

void Renderer::stamp(int place) const {
  if (measured_) meter_.stamp(place);
}

Expected<void> Renderer::draw(const Camera& camera, const RenderOptions& asked,
                              const RenderTarget& target) {
  const RenderOptions options = for_scene(asked, scene_.filter);
  if (auto ok = check_view(camera, options); !ok) return ok;
  if (auto ok = pipeline_->prepare(options.filter->compensated); !ok) return ok;
  if (measured_) meter_.begin();
  stamp(0);
  const bool any = scene_.count > 0;
  if (any) {
    draw_scene(camera, options, target);
  } else {
    stamp(1);
    stamp(2);
    clear(api_, options.background, target);
  }
  api_.Disable(GL_SCISSOR_TEST);  // clear() may have set it, for the draw as well
  stamp(3);
  resolve_.run(api_, target);
  stamp(4);
  if (measured_) end_measuring(any);
  return {};
}

void Renderer::end_measuring(bool any) {
  const sort::OrderTexture* known = sorter_->order_texture();
  if (any && known == nullptr) {
    meter_.end(sorter_->count());
  } else {
    meter_.end(any ? known->count : 0U);
  }
}

void Renderer::draw_scene(const Camera& camera, const RenderOptions& options,
                          const RenderTarget& target) {
  const Camera view = scaled_camera(camera, target.blend_width(), target.blend_height());
  const ApproximationSettings& approximation = settings_.approximation;
  const sort::SortView sorted_for =
      sort_view(camera, options.near_plane, scene_, approximation.key_bits);
  const FrameUniforms values =
      make_frame_uniforms(view, options, approximation, scene_, sorted_for.keys);
  uniforms_.write(0, std::as_bytes(std::span(&values, 1)));
  uniforms_.bind_base(GL_UNIFORM_BUFFER, 0);
  pipeline_->project(options.filter->compensated);
  stamp(1);
  sort(sorted_for);
  stamp(2);
  pipeline_->draw(*sorter_, options.background, target);
}

void Renderer::sort(const sort::SortView& view) {
  const double allowed = settings_.approximation.resort_motion;
  // Orders of the CPU depend on nothing else: a view that stands still comes to rest
  const bool same = sorter_->needs_positions() && sorted_ == view;
  const bool near = sorted_ && allowed > 0 && motion_between(*sorted_, view) <= allowed;
  if (!same && !near) {
    sorter_->sort(view, settings_.compute ? &projection().keys() : nullptr);
    sorted_ = view;
  }
  if (waits_) sorter_->finish();
  sorter_->collect();
}

Expected<Image<std::uint8_t>> Renderer::read_shown(const RenderTarget& target, int longest) const {
  const glm::ivec2 all(target.width(), target.height());
  const int longer = std::max(all.x, all.y);
  const bool reduces = longest > 0 && longer > longest;
  // The first halving here, where it averages four pixels: an image of all of it is not needed
  const double ratio = reduces ? std::max(0.5, static_cast<double>(longest) / longer) : 1;
  const glm::ivec2 size = glm::max(glm::ivec2(glm::round(ratio * glm::dvec2(all))), glm::ivec2(1));
  if (reduces) {
    const auto image =
        RenderTarget::create(api_, size.x, size.y, target.format(), Accumulation::direct);
    if (!image) return std::unexpected(image.error());
    resolve_.to_rows(api_, target, size, 0, *image);
    return read_image(api_, *image, longest);
  }
  const auto strip = make_strip(size);
  if (!strip) return std::unexpected(strip.error());
  Image<std::uint8_t> whole(size.x, size.y, 4);
  for (int first = 0; first < size.y; first += strip->height()) {
    resolve_.to_rows(api_, target, size, first, *strip);
    const auto part = read_image(api_, *strip);
    if (!part) return std::unexpected(part.error());
    const int count = std::min(strip->height(), size.y - first);
    std::copy_n(part->pixels.begin(), std::ptrdiff_t{4} * size.x * count, whole.at(0, first));
  }
  return whole;
}

/// A strip of as many rows of an image as there is room for.
Expected<RenderTarget> Renderer::make_strip(const glm::ivec2& size) const {
  for (int rows = std::min(size.y, RenderTarget::kRowsRead);; rows = (rows + 1) / 2) {
    auto strip =
        RenderTarget::create(api_, size.x, rows, TargetFormat::rgba8, Accumulation::direct);
    if (strip || !api_.out_of_memory || rows == 1) return strip;
    api_.out_of_memory = false;
  }
}

Expected<std::vector<ProjectedSplat>> Renderer::read_projected(int width, int height,
                                                               std::uint32_t most) const {
  const auto words = pipeline_->read_projected(std::min(most, scene_.count));
  if (!words) return std::unexpected(words.error());
  return unpack_projected_splats(*words, settings_.splat_precision, width, height);
}

Expected<FrameStats> Renderer::stats() {
  const auto stats = meter_.wait();
  if (!stats) return std::unexpected(stats.error());
  return stats->value_or(FrameStats());
}

}  // namespace fluxgs::render
