// A walk over a ByteSource from a place to its end, of which a window is in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fluxgs/byte_source.h"

namespace fluxgs::io {

class ByteWindow {
 public:
  ByteWindow(const ByteSource& source, std::uint64_t begin);

  /// Bytes from here to the end.
  std::uint64_t left() const { return source_.size() - at_; }

  /// The bytes from here on: `least` at least, or all that are left. Empty after an error, too.
  std::span<const std::byte> ahead(std::size_t least);

  /// Goes on; false, and it stays, where there are not so many.
  bool skip(std::uint64_t bytes);

  /// Why bytes could not be read; then all that is left is gone.
  const std::optional<Error>& error() const { return error_; }

 private:
  const ByteSource& source_;
  std::uint64_t at_;
  std::uint64_t window_at_ = 0;
  std::span<const std::byte> window_;
  std::vector<std::byte> room_;
  std::optional<Error> error_;
};

}  // namespace fluxgs::io
