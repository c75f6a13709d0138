// Settings that trade accuracy for speed. Every setting is exact, or off, by default; `fluxgs
// report render` measures the cost and gain of each.
#pragma once

#include <cstddef>

#include "fluxgs/error.h"
#include "gl/quirks.h"
#include "sort/background_sort.h"

namespace fluxgs::render {

enum class SorterKind {
  gpu_radix,  ///< on the GPU, every frame's order is its own
  cpu_async,  ///< on a thread of the CPU; frames are drawn with the newest order there is
  exact,      ///< float64 on the CPU, waited for: for measuring the others
};

/// Format in which the projection pass hands a splat to the draw (shaders/projected_splat.glsl).
enum class SplatPrecision {
  full,  ///< 32 bytes, float32
  half,  ///< 16 bytes
};

constexpr std::size_t projected_splat_bytes(SplatPrecision precision) {
  return precision == SplatPrecision::full ? 32 : 16;
}

/// Details that a frame may leave out. They can be changed from frame to frame.
struct ApproximationSettings {
  /// Maximum bits of a depth key: 10…32. A scene's range of depths usually needs 26, which order
  /// the splats by all the bits of their float32 depths. 24 cost no measurable error and one pass
  /// of the GPU's sort less; see sort/depth_keys.h.
  int key_bits = 24;
  /// px²: splats that weigh less are not drawn. The weight is the sum of α over all pixels that a
  /// splat covers, 2π·opacity·√det Σ′.
  double min_weight = 0;
  /// Quads end at so many standard deviations, or where α falls below alpha_min if that is nearer;
  /// 0: only there.
  double max_deviations = 0;
  /// The camera may move by so much before the splats are sorted again, in radians: the angle it
  /// turned by, or the distance it moved by over its distance to the scene's middle.
  double resort_motion = 0;
  bool operator==(const ApproximationSettings&) const = default;
};

constexpr int kMostSlices = 64;
constexpr int kMostQuads = 128;  // of a batch: the work group of shaders/draw_arguments.comp

/// Settings that the programs and buffers are made for.
struct RendererSettings {
  SorterKind sorter = SorterKind::gpu_radix;
  SplatPrecision splat_precision = SplatPrecision::full;
  int batch = 128;          ///< quads per instance, 1…128
  int sort_digit_bits = 8;  ///< 4…8, for gpu_radix
  bool timestamps = false;  ///< record stage times where the driver can
  /// Project in compute shaders; otherwise in fragment shaders, with a sorter of the CPU (cpu_async
  /// in place of gpu_radix) and without slices. False where the driver has none
  /// (gl::Capabilities::compute).
  bool compute = true;
  /// Without compute: project in vertex shaders, where fragments are not exact enough
  /// (gl::Quirks::fragment_projection_fails).
  bool project_in_vertices = false;
  /// Read projected_splats through textures even where the vertex stage has storage buffers.
  bool texture_fetch = false;
  /// Blend front to back in so many parts and mark finished pixels between them, which later parts
  /// skip (SaturationMarks); 1…kMostSlices, 1: back to front, without marks. 1 is taken where the
  /// driver lacks framebuffer fetch or storage buffers in the vertex stage.
  int slices = 1;
  /// Where cpu_async sorts; empty: on a thread.
  sort::MakeBackgroundSort background_sort = {};
  ApproximationSettings approximation = {};
};

/// Those to look at a scene with: 16-bit keys where the GPU is a phone's (gl::Quirks::tiles), which
/// take two passes instead of three and cost less than half floats do (docs/renderer.md).
ApproximationSettings default_approximation(const gl::Quirks& quirks);

/// Fail, naming the field, on values out of their range.
Expected<void> check_settings(const RendererSettings& settings);
Expected<void> check_approximation(const ApproximationSettings& approximation);

}  // namespace fluxgs::render
