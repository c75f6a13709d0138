// Whole numbers as people write them.
#pragma once

#include <optional>
#include <string_view>

namespace fluxgs {

/// 30000, 3e4, 30k, 1.5M or 2G. Nothing for other text, and beyond 2⁵³, up to which doubles hold
/// all whole numbers.
std::optional<double> whole_number(std::string_view text);

}  // namespace fluxgs
