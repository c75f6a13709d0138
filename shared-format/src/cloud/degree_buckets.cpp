#include "cloud/degree_buckets.h"

#include <algorithm>
#include <array>
#include <utility>

#include "fluxgs/splat_degree.h"

namespace fluxgs::io {
namespace {

/// Moves what is too small to the next degree that any splat has.
void join_small(std::array<std::vector<std::uint32_t>, 4>& by_degree) {
  for (auto small = by_degree.begin(); small != by_degree.end(); ++small) {
    const auto next = std::find_if(small + 1, by_degree.end(),
                                   [](const auto& splats) { return !splats.empty(); });
    if (small->size() >= kMinBucket || next == by_degree.end()) continue;
    next->insert(next->end(), small->begin(), small->end());
    std::ranges::sort(*next);
    small->clear();
  }
}

}  // namespace

std::vector<DegreeBucket> degree_buckets(const SplatCloud& cloud,
                                         std::span<const std::uint32_t> splats) {
  std::array<std::vector<std::uint32_t>, 4> by_degree;
  for (const std::uint32_t i : splats)
    by_degree[static_cast<std::size_t>(sh_degree_of(cloud, i))].push_back(i);
  join_small(by_degree);
  std::vector<DegreeBucket> buckets;
  for (int degree = 0; degree < 4; ++degree)
    if (auto& own = by_degree[static_cast<std::size_t>(degree)]; !own.empty())
      buckets.push_back({degree, std::move(own)});
  return buckets;
}

SplatCloud cloud_of(const DegreeBucket& bucket, const SplatCloud& cloud) {
  SplatCloud part = in_order(cloud, bucket.splats);
  limit_sh_degree(part, bucket.sh_degree);
  return part;
}

}  // namespace fluxgs::io
