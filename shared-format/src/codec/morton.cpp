#include "codec/morton.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <glm/common.hpp>

namespace fluxgs::codec {
namespace {

constexpr double kCells = 0x1p21;

/// abc… becomes a00b00c00…
std::uint64_t spread(std::uint64_t v) {
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const std::vector<glm::vec3>& positions) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const glm::vec3& p : positions) {
    low = glm::min(low, glm::dvec3(p));
    high = glm::max(high, glm::dvec3(p));
  }
  const glm::dvec3 extent = high - low;
  const double side = std::max({extent.x, extent.y, extent.z, 1e-300});
  std::vector<std::uint64_t> keys(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3 cell = (glm::dvec3(positions[i]) - low) * ((kCells - 1) / side);
    keys[i] = spread(static_cast<std::uint64_t>(cell.x)) |
              spread(static_cast<std::uint64_t>(cell.y)) << 1 |
              spread(static_cast<std::uint64_t>(cell.z)) << 2;
  }
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return keys[i]; });
  return order;
}

}  // namespace fluxgs::codec
