#include "render/splat_budget.h"

#include "fluxgs/contribution.h"

namespace fluxgs::render {

std::vector<std::uint32_t> max_contributing(const SplatCloud& cloud, std::size_t count) {
  std::vector<double> values(cloud.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = contribution(cloud, i);
  return first_indices(cloud.size(), count, [&](std::uint32_t a, std::uint32_t b) {
    return values[a] != values[b] ? values[a] > values[b] : a < b;
  });
}

}  // namespace fluxgs::render
