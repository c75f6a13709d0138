#include "trainer/densify/metric_maps.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fluxgs {
namespace {

bool counts(const Image<std::uint8_t>& used, int x, int y) {
  return used.pixels.empty() || *used.at(x, y) != 0;
}

float unit_of(const PlanarImage& loss, ScoreUnit unit, const Image<std::uint8_t>& used) {
  if (unit == ScoreUnit::raw) return 1;
  std::vector<float> values;
  for (int y = 0; y < loss.height(); ++y)
    for (int x = 0; x < loss.width(); ++x)
      if (counts(used, x, y) && std::isfinite(loss.row(0, y)[x]))
        values.push_back(loss.row(0, y)[x]);
  if (values.empty()) return kMinUnit;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return std::max(*at, kMinUnit);
}

}  // namespace

PlanarImage metric_maps(const PlanarImage& loss, const ScoreOptions& options,
                        const Image<std::uint8_t>& used) {
  const float unit = unit_of(loss, options.unit, used);
  const float bad = unit * static_cast<float>(options.tau_plus),
              good = unit * static_cast<float>(options.tau_minus);
  PlanarImage maps(loss.width(), loss.height(), used.pixels.empty() ? 2 : 3);
  if (!used.pixels.empty()) copy_mask(used, maps, 2);
  for (int y = 0; y < loss.height(); ++y)
    for (int x = 0; x < loss.width(); ++x) {
      if (!counts(used, x, y)) continue;
      const float l = loss.row(0, y)[x];
      maps.row(0, y)[x] = l <= bad ? 0.0f : 1.0f;
      maps.row(1, y)[x] = l < good ? std::max(l, 0.0f) : 0.0f;
    }
  return maps;
}

}  // namespace fluxgs
