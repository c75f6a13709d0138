// Text from a stranger, made fit for a message of one line.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fluxgs::io {

/// At most `most` bytes of it and dots for the rest. A question mark stands for whatever is not
/// printable ASCII: control characters move a terminal's cursor, cut or false UTF-8 breaks others.
inline std::string printable(std::string_view text, std::size_t most = 60) {
  std::string shown(text.substr(0, most));
  for (char& c : shown) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text.size() > most ? shown + "..." : shown;
}

}  // namespace fluxgs::io
