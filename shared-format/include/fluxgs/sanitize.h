// Text from a stranger, made fit for a message of one line.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace fluxgs {

/// At most `most` bytes of it and dots for the rest. A question mark stands for whatever is not
/// printable ASCII: control characters move a terminal's cursor, cut or false UTF-8 breaks others.
inline std::string sanitized(std::string_view text, std::size_t most = 60) {
  std::string shown(text.substr(0, most));
  std::ranges::replace_if(shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text.size() > most ? shown + "..." : shown;
}

/// The same for what may be a name on this machine: only control characters are replaced.
inline std::string one_line(std::string_view text, std::size_t most = 200) {
  std::string shown(text.substr(0, most));
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::ranges::replace_if(shown, control, '?');
  return text.size() > most ? shown + "..." : shown;
}

}  // namespace fluxgs
