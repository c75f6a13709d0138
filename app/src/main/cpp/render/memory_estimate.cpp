#include "render/memory_estimate.h"

#include <algorithm>
#include <cmath>

#include "render/draw_pass.h"
#include "render/fragment_pipeline.h"
#include "render/frame_meter.h"
#include "render/frame_uniforms.h"
#include "render/ordered_splats.h"
#include "render/quad_indices.h"
#include "render/scene_packing.h"

namespace fluxgs::render {
namespace {

constexpr std::size_t kWord = sizeof(std::uint32_t), kVec4 = 16;

std::size_t at_least_a_word(std::size_t bytes) { return std::max(bytes, kWord); }  // gl/buffer.cpp

std::size_t scene_bytes(const DegreeCounts& splats, bool compute) {
  if (!compute) return FragmentPipeline::scene_bytes(splats);
  return at_least_a_word(4 * kVec4 * count_of(splats)) + at_least_a_word(sh_bytes(splats));
}

std::size_t gpu_sorter_bytes(std::uint64_t count, int digit_bits) {
  const std::size_t radix = std::size_t{1} << digit_bits;
  const std::size_t blocks = std::max<std::size_t>((count + 2047) / 2048, 1);
  return kWord * (4 + radix + radix * blocks) + 2 * at_least_a_word(2 * kWord * count);
}

/// The orders that a sorter of the CPU uploads.
std::size_t uploaded_orders(SorterKind kind) { return kind == SorterKind::cpu_async ? 3 : 1; }

/// The buffers of a frame with compute shaders, but for what both forms have.
std::size_t compute_bytes(std::uint64_t count, const RendererSettings& s) {
  const std::size_t projected_splats = projected_splat_bytes(s.splat_precision) * (count + 1);
  const std::uint64_t entries = count + static_cast<std::uint64_t>(s.batch);
  const std::size_t order = kWord * entries;
  std::size_t bytes = projected_splats + at_least_a_word(kWord * count);
  bytes += s.sorter == SorterKind::gpu_radix ? order + gpu_sorter_bytes(count, s.sort_digit_bits)
                                             : uploaded_orders(s.sorter) * (order + kWord);
  if (s.texture_fetch) bytes += ordered_splat_bytes(entries, s.splat_precision);
  return bytes + draw_arguments_bytes(s.slices);
}

/// The textures of a frame without them.
std::size_t fragment_bytes(std::uint64_t count, const RendererSettings& s) {
  const std::uint64_t entries = count + static_cast<std::uint64_t>(s.batch);
  return FragmentPipeline::projected_bytes(count, s.splat_precision) +
         uploaded_orders(s.sorter) * gl::TexelArray::bytes(GL_R32UI, entries);
}

std::size_t frame_bytes(std::uint64_t count, const RendererSettings& s) {
  return (s.compute ? compute_bytes(count, s) : fragment_bytes(count, s)) +
         kIndexBytesOfAQuad * static_cast<std::size_t>(s.batch) + sizeof(FrameUniforms) +
         FrameMeter::kBytes;
}

std::size_t target_bytes(const TargetPlan& t) {
  if (t.width == 0 || t.height == 0) return 0;
  const std::size_t pixels = static_cast<std::size_t>(t.width) * static_cast<std::size_t>(t.height);
  if (t.for_window) return pixels * blend_pixel_bytes(t);
  const auto scaled = [&](int size) {
    return static_cast<std::size_t>(std::max(1L, std::lround(size * t.scale)));
  };
  const std::size_t blended = scaled(t.width) * scaled(t.height);
  const bool same =
      blended == pixels &&
      (t.accumulation == Accumulation::direct ||
       (t.accumulation == Accumulation::half_float && t.format == TargetFormat::rgba16f));
  return pixels * pixel_bytes(t.format) + (same ? 0 : blended * blend_pixel_bytes(t)) +
         (t.marks ? 2 * blended : 0);
}

/// Renderer::read_shown(): strips of the image, or a half of it in each direction and what it is
/// halved into.
std::size_t reading_bytes(const TargetPlan& t) {
  if (!t.for_window) return 0;
  const std::size_t width = static_cast<std::size_t>(t.width),
                    height = static_cast<std::size_t>(t.height);
  const std::size_t strip = width * std::min(height, std::size_t{RenderTarget::kRowsRead});
  const std::size_t half = ((width + 1) / 2) * ((height + 1) / 2);
  return pixel_bytes(t.format) * std::max(strip, half + half / 2);
}

}  // namespace

std::size_t pixel_bytes(TargetFormat format) { return format == TargetFormat::rgba8 ? 4 : 8; }

std::size_t blend_pixel_bytes(const TargetPlan& t) {
  if (t.accumulation == Accumulation::single_float) return 16;
  return t.accumulation == Accumulation::half_float ? 8 : pixel_bytes(t.format);
}

MemoryEstimate estimate_memory(const DegreeCounts& splats, const RendererSettings& settings,
                               const TargetPlan& target) {
  return {.scene = scene_bytes(splats, settings.compute),
          .frame = frame_bytes(count_of(splats), settings),
          .targets = target_bytes(target),
          .reading = reading_bytes(target)};
}

std::uint64_t splats_that_fit(std::size_t bytes, const DegreeCounts& scene,
                              const RendererSettings& settings, const TargetPlan& target) {
  const auto fits = [&](std::uint64_t count) {
    return estimate_memory(largest_of(scene, count), settings, target).total() <= bytes;
  };
  const std::uint64_t all = count_of(scene);
  if (fits(all)) return all;
  std::uint64_t low = 0, high = all;  // high never fits
  while (high - low > 1) {
    const std::uint64_t middle = low + (high - low) / 2;
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace fluxgs::render
