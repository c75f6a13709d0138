#include "bench/samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fluxgs::bench {

Summary summarize(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::ranges::sort(samples);
  const std::size_t n = samples.size();
  const auto at_rank = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(n)));
  return {.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(n),
          .median = (samples[(n - 1) / 2] + samples[n / 2]) / 2,
          .p95 = samples[at_rank - 1],
          .least = samples.front()};
}

}  // namespace fluxgs::bench
