// Picking what belongs to some splats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fluxgs::io {

/// The first `kept` of the `each` values that each of these splats has in `from`; nothing of
/// nothing.
inline std::vector<float> gather(std::span<const float> from, std::span<const std::uint32_t> splats,
                                 std::size_t each, std::size_t kept) {
  std::vector<float> result;
  if (from.empty()) return result;
  result.reserve(kept * splats.size());
  for (const std::uint32_t i : splats) {
    const auto own = from.subspan(i * each, kept);
    result.insert(result.end(), own.begin(), own.end());
  }
  return result;
}

}  // namespace fluxgs::io
