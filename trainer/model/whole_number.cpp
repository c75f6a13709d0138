#include "trainer/model/whole_number.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace fluxgs {

std::optional<double> whole_number(std::string_view text) {
  double factor = 1;
  if (text.ends_with('k') || text.ends_with('K')) factor = 1e3;
  if (text.ends_with('M')) factor = 1e6;
  if (text.ends_with('G')) factor = 1e9;
  if (factor > 1) text.remove_suffix(1);
  double number = 0;
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc() || rest != text.data() + text.size()) return {};
  const double value = std::round(number * factor);
  constexpr double kRounding = 1e-6;
  if (!(std::abs(value - number * factor) < kRounding && std::abs(value) <= 0x1p53)) return {};
  return value;
}

}  // namespace fluxgs
