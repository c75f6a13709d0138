#include "render/splat_budget.h"

#include <algorithm>
#include <numeric>

#include "fluxgs/contribution.h"

namespace fluxgs::render {

std::vector<std::uint32_t> max_contributing(const SplatCloud& cloud, std::size_t count) {
  std::vector<double> values(cloud.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = contribution(cloud, i);
  std::vector<std::uint32_t> splats(cloud.size());
  std::iota(splats.begin(), splats.end(), 0U);
  if (count >= splats.size()) return splats;
  std::ranges::nth_element(splats, splats.begin() + static_cast<std::ptrdiff_t>(count),
                           [&](std::uint32_t a, std::uint32_t b) {
                             return values[a] != values[b] ? values[a] > values[b] : a < b;
                           });
  splats.resize(count);
  std::ranges::sort(splats);
  return splats;
}

}  // namespace fluxgs::render
