#include "trainer/data/pyramid.h"

#include <algorithm>

#include "trainer/data/photo_memory.h"

namespace fluxgs {
namespace {

std::uint8_t mean(int a, int b, int c, int d) {
  return static_cast<std::uint8_t>((a + b + c + d + 2) / 4);
}

Image<std::uint8_t> half_of(const Image<std::uint8_t>& in) {
  if (in.pixels.empty()) return {};
  Image<std::uint8_t> out(in.width / 2, in.height / 2, in.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int k = 0; k < in.channels; ++k)
        out.at(x, y)[k] = mean(in.at(2 * x, 2 * y)[k], in.at(2 * x + 1, 2 * y)[k],
                               in.at(2 * x, 2 * y + 1)[k], in.at(2 * x + 1, 2 * y + 1)[k]);
  return out;
}

}  // namespace

View halved(const View& view) {
  View out = {.camera = view.camera,
              .rgb = half_of(view.rgb),
              .path = view.path,
              .used = half_of(view.used),
              .alpha = half_of(view.alpha),
              .background = view.background};
  for (std::uint8_t& v : out.used.pixels) v = v >= kCounts ? 255 : 0;
  Camera& c = out.camera;
  c.width = view.camera.width / 2, c.height = view.camera.height / 2;
  c.fx /= 2, c.fy /= 2, c.cx /= 2, c.cy /= 2;
  if (is_in_file(view.rgb)) move_to_files(out);
  let_go(view);
  return out;
}

ViewPyramid::ViewPyramid(const std::vector<View>& views, int levels, int least) : full_(views) {
  for (int level = 1; level <= levels; ++level) {
    const std::vector<View>& before = at(level - 1);
    const bool large = std::ranges::all_of(before, [&](const View& p) {
      return std::min(p.camera.width, p.camera.height) / 2 >= least;
    });
    if (!large) break;
    std::vector<View> half;
    half.reserve(before.size());
    for (const View& view : before) half.push_back(halved(view));
    smaller_.push_back(std::move(half));
  }
}

const std::vector<View>& ViewPyramid::at(int level) const {
  const int last = static_cast<int>(smaller_.size());
  return level <= 0 || last == 0 ? full_
                                 : smaller_[static_cast<std::size_t>(std::min(level, last) - 1)];
}

}  // namespace fluxgs
