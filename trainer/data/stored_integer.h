// Integers of image files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fluxgs {

/// The integer of `count` bytes, at most 4, from `at`; all of them must be there. `little`: the
/// first byte is the lowest.
inline std::uint32_t stored_integer(std::span<const std::uint8_t> bytes, std::size_t at,
                                    std::size_t count, bool little) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i)
    value = value << 8 | bytes[little ? at + count - 1 - i : at + i];
  return value;
}

}  // namespace fluxgs
