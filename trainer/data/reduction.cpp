#include "trainer/data/reduction.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fluxgs {
namespace {

constexpr int kSmallestSide = 32;  // pixels; less shows no scene

}  // namespace

ImageSize reduced_size(ImageSize stored, int factor) {
  if (factor > 0) return {stored.width / factor, stored.height / factor};
  const int longest = std::max(stored.width, stored.height);
  if (longest <= kDefaultLongestSide) return stored;
  const auto reduced = [&](int side) {
    return std::max(1, static_cast<int>(
                           std::lround(static_cast<double>(side) * kDefaultLongestSide / longest)));
  };
  return {reduced(stored.width), reduced(stored.height)};
}

Expected<void> check_reduction(const Source& source, int factor) {
  if (factor <= 1) return {};
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames) {
      const ImageSize stored{frame.lens.width, frame.lens.height};
      const ImageSize reduced = reduced_size(stored, factor);
      if (std::min(reduced.width, reduced.height) >= kSmallestSide) continue;
      const int most = std::max(1, std::min(stored.width, stored.height) / kSmallestSide);
      return fail(frame.file.string(), "downscale",
                  fmt::format("{} leaves {}x{} of {}x{} pixels, expected at most {}", factor,
                              reduced.width, reduced.height, stored.width, stored.height, most));
    }
  return {};
}

}  // namespace fluxgs
