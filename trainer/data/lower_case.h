// Names of files compared in any case.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace fluxgs {

/// The text with A to Z in lower case; other bytes stay.
inline std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace fluxgs
