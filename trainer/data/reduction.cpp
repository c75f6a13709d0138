#include "trainer/data/reduction.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trainer/data/file_list.h"

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

Expected<void> remove_too_small(Source& source, int factor) {
  if (factor <= 1) return {};
  const auto too_small = [&](const SourceFrame& frame) {
    const ImageSize reduced = reduced_size({frame.lens.width, frame.lens.height}, factor);
    return std::min(reduced.width, reduced.height) < kSmallestSide;
  };
  const std::size_t all = source.frames.size() + source.test_frames.size();
  FileList small;
  const SourceFrame* first = nullptr;
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames)
      if (too_small(frame)) {
        small.add(frame.file.string());
        if (first == nullptr) first = &frame;
      }
  if (first == nullptr) return {};
  const ImageSize stored{first->lens.width, first->lens.height};
  const ImageSize reduced = reduced_size(stored, factor);
  const std::string what =
      fmt::format("{} leaves {}x{} of {}x{} pixels, less than {}; expected at most {}", factor,
                  reduced.width, reduced.height, stored.width, stored.height, kSmallestSide,
                  std::max(1, std::min(stored.width, stored.height) / kSmallestSide));
  if (2 * small.size() >= all) return fail(first->file.string(), "downscale", what);
  for (auto* frames : {&source.frames, &source.test_frames}) std::erase_if(*frames, too_small);
  source.skipped_images += small.size();
  source.warnings.push_back(fmt::format("left out, since --downscale {}: {}", what, small.text()));
  return {};
}

}  // namespace fluxgs
