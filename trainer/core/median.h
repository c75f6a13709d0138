// The median of some values.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

namespace fluxgs {

/// The upper one of two in the middle; nothing of no values.
inline std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace fluxgs
