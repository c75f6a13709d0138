#include "trainer/train/memory_budget.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "fluxgs/io/compact_glb.h"
#include "trainer/compress/scene_error.h"
#include "trainer/compress/view_weights.h"
#include "trainer/core/parameters.h"
#include "trainer/data/photo_memory.h"
#include "trainer/train/progressive_resolution.h"
#include "trainer/train/schedule.h"

namespace fluxgs {
namespace {

constexpr double kMebibyte = 1 << 20;
constexpr double kProgram = 80 * kMebibyte;  // code, libraries, decoding of images
constexpr double kPlanes = 40;               // floats a pixel: images, loss and its gradient
constexpr double kPerSplat = 384;  // bytes: projected splats, sums, keys, visibility, statistics
constexpr double kPerPair = 160;   // bytes: entries, bins, gradients, with the room vectors grow by
constexpr std::size_t kFewest = 1000;

/// Of what does not lie in files
double view_bytes(const std::vector<View>& views) {
  double sum = 0;
  for (const View& view : views)
    if (!is_in_file(view.rgb))
      sum += static_cast<double>(view.rgb.pixels.size() + view.used.pixels.size() +
                                 view.alpha.pixels.size());
  return sum;
}

double fixed_bytes(const Dataset& data, const TrainOptions& options) {
  double pixels = 0;
  for (const auto* views : {&data.train, &data.test})
    for (const View& view : *views)
      pixels = std::max(pixels, static_cast<double>(view.rgb.pixels.size()) / 3);
  const double smaller = options.get<ProgressiveResolutionOptions>().levels > 0 ? 1.0 / 3 : 0;
  // What the scene's file is measured by
  const double planes = kPlanes + 3.0 * kEvaluationCameras;
  return kProgram + (1 + smaller) * view_bytes(data.train) + view_bytes(data.test) +
         planes * sizeof(float) * pixels;
}

double bytes_per_splat(const Dataset& data, const TrainOptions& options, double pairs) {
  // Parameters, two moments, gradients, and a copy of one of them. While the scene is stored: it
  // as it was trained, shown, in the file's order, with one attribute quantized, and read back,
  // twice what the coder makes of it, and gradients again; what the file's encoder knows of the
  // views, and a copy of that
  const int degree = initial_sh_degree(options);
  const double floats =
      (5.0 + 8.0) * row::count(degree) + 2.0 * static_cast<double>(sensitivity_size(degree));
  double bytes = floats * sizeof(float) + kPerSplat + kPerPair * pairs;
  // Now and then, and when the scene is stored, another rasterizer and the splats' weights in views
  // (ViewWeights)
  bytes += kPerSplat + kPerPair * pairs +
           sizeof(float) * static_cast<double>(std::min(data.train.size(), kMostWeighedViews));
  return bytes;
}

}  // namespace

double pairs_per_splat(const RasterCounts& counts) {
  if (counts.visible < 1000) return 0;
  return static_cast<double>(counts.tile_pairs) / static_cast<double>(counts.visible);
}

std::size_t training_memory(const Dataset& data, const TrainOptions& options, std::size_t splats,
                            double pairs) {
  return static_cast<std::size_t>(fixed_bytes(data, options) +
                                  static_cast<double>(splats) *
                                      bytes_per_splat(data, options, pairs));
}

std::size_t splats_in_memory(const Dataset& data, const TrainOptions& options, double pairs) {
  if (options.max_memory == 0) return std::numeric_limits<std::size_t>::max();
  const double room =
      static_cast<double>(options.max_memory) * kMebibyte - fixed_bytes(data, options);
  return static_cast<std::size_t>(std::max(room, 0.0) / bytes_per_splat(data, options, pairs));
}

Expected<void> check_memory(const Dataset& data, const TrainOptions& options) {
  if (splats_in_memory(data, options, kDefaultPairs) >= kFewest) return {};
  return fail("", "--max-memory",
              fmt::format("{} MiB are too few: {:.0f} MiB are taken before the first splat; use "
                          "--downscale, a small --photo-memory, or at least {:.0f}",
                          options.max_memory, fixed_bytes(data, options) / kMebibyte,
                          training_memory(data, options, kFewest, kDefaultPairs) / kMebibyte + 1));
}

}  // namespace fluxgs
