#include "fluxgs/morton.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include <glm/common.hpp>

namespace fluxgs {
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

/// Keys and the indices that go with them.
struct Keyed {
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> indices;
};

std::uint64_t key_of(const glm::ivec3& cell) {
  const auto part = [&](int axis) {
    return spread(static_cast<std::uint64_t>(cell[axis])) << axis;
  };
  return part(0) | part(1) | part(2);
}

constexpr int kDigitBits = 11, kKeyBits = 63;

std::size_t digit(std::uint64_t key, int shift) {
  return (key >> shift) & ((std::size_t{1} << kDigitBits) - 1);
}

/// Moves `from` to `to` in the order of one digit; equal ones keep theirs. False where all have the
/// same, and nothing is moved.
bool sort_by_digit(const Keyed& from, int shift, Keyed& to) {
  std::array<std::uint32_t, std::size_t{1} << kDigitBits> next{};
  for (const std::uint64_t key : from.keys) ++next[digit(key, shift)];
  if (next[digit(from.keys.front(), shift)] == from.keys.size()) return false;
  std::exclusive_scan(next.begin(), next.end(), next.begin(), 0U);
  for (std::size_t i = 0; i < from.keys.size(); ++i) {
    const std::uint32_t place = next[digit(from.keys[i], shift)]++;
    to.keys[place] = from.keys[i];
    to.indices[place] = from.indices[i];
  }
  return true;
}

/// Sorts by the keys; equal ones keep their order. `other` is room.
void sort(Keyed& sorted, Keyed& other) {
  other = sorted;
  for (int shift = 0; shift < kKeyBits; shift += kDigitBits)
    if (sort_by_digit(sorted, shift, other)) std::swap(sorted, other);
}

Keyed keyed(std::size_t count) {
  Keyed result{std::vector<std::uint64_t>(count), std::vector<std::uint32_t>(count)};
  std::iota(result.indices.begin(), result.indices.end(), 0U);
  return result;
}

}  // namespace

std::vector<std::uint32_t> morton_order(const std::vector<glm::vec3>& positions) {
  if (positions.empty()) return {};
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const glm::vec3& p : positions) {
    low = glm::min(low, glm::dvec3(p));
    high = glm::max(high, glm::dvec3(p));
  }
  const glm::dvec3 extent = high - low;
  const double side = std::max({extent.x, extent.y, extent.z, 1e-300});
  Keyed sorted = keyed(positions.size()), other;
  for (std::size_t i = 0; i < positions.size(); ++i)
    sorted.keys[i] = key_of(glm::ivec3((glm::dvec3(positions[i]) - low) * ((kCells - 1) / side)));
  sort(sorted, other);
  return std::move(sorted.indices);
}

std::vector<std::uint32_t> morton_order(std::span<const glm::ivec3> cells) {
  if (cells.empty()) return {};
  // A key has no room for all bits: first by the low ones, then by the others
  constexpr int kLowBits = 12, kLowest = (1 << kLowBits) - 1;
  Keyed sorted = keyed(cells.size()), other;
  for (std::size_t i = 0; i < cells.size(); ++i) sorted.keys[i] = key_of(cells[i] & kLowest);
  sort(sorted, other);
  for (std::size_t i = 0; i < cells.size(); ++i)
    sorted.keys[i] = key_of(cells[sorted.indices[i]] >> kLowBits);
  sort(sorted, other);
  return std::move(sorted.indices);
}

}  // namespace fluxgs
