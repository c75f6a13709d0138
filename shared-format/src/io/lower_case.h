// Text in lower case, in ASCII: formats and extensions know no other letters.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace fluxgs::io {

/// Bytes above 127 stay as they are.
inline std::string lower_case(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return result;
}

}  // namespace fluxgs::io
