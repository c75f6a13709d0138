#include "trainer/data/pyramid.h"

#include <algorithm>

namespace fluxgs {
namespace {

std::uint8_t mean(int a, int b, int c, int d) {
  return static_cast<std::uint8_t>((a + b + c + d + 2) / 4);
}

}  // namespace

View halved(const View& view) {
  View out{view.camera, {}, view.path};
  Camera& c = out.camera;
  c.width = view.camera.width / 2, c.height = view.camera.height / 2;
  c.fx /= 2, c.fy /= 2, c.cx /= 2, c.cy /= 2;
  const Image<std::uint8_t>& in = view.rgb;
  out.rgb = Image<std::uint8_t>(c.width, c.height, in.channels);
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x)
      for (int k = 0; k < in.channels; ++k)
        out.rgb.at(x, y)[k] = mean(in.at(2 * x, 2 * y)[k], in.at(2 * x + 1, 2 * y)[k],
                                   in.at(2 * x, 2 * y + 1)[k], in.at(2 * x + 1, 2 * y + 1)[k]);
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
