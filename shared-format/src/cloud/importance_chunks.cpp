#include "cloud/importance_chunks.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "fluxgs/contribution.h"

namespace fluxgs::io {

SplatChunk one_chunk(const SplatCloud& cloud) {
  SplatChunk splats(cloud.size());
  std::iota(splats.begin(), splats.end(), 0U);
  return splats;
}

std::vector<SplatChunk> importance_chunks(const SplatCloud& cloud) {
  // The more channels a splat has, the more bytes go to those that are stored more exactly
  const double first = 0.04 - 0.005 * cloud.sh_degree;
  std::vector<float> values(cloud.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = static_cast<float>(contribution(cloud, i));
  const auto adds_more = [&](std::uint32_t a, std::uint32_t b) {
    return values[a] != values[b] ? values[a] > values[b] : a < b;
  };
  SplatChunk splats = one_chunk(cloud);
  std::vector<SplatChunk> chunks;
  auto begin = splats.begin();
  for (const double share : {first, 3 * first, 6 * first, 1.0}) {
    const auto wanted = static_cast<std::ptrdiff_t>(share * static_cast<double>(cloud.size()));
    const auto end = begin + std::min(wanted, splats.end() - begin);
    std::nth_element(begin, end, splats.end(), adds_more);
    chunks.emplace_back(begin, end);
    std::ranges::sort(chunks.back());
    begin = end;
  }
  return chunks;
}

}  // namespace fluxgs::io
