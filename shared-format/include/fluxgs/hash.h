// FNV-1a, 64 bits: a checksum against damage and a name for content, no protection against intent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fluxgs {

/// Hash of no bytes.
inline constexpr std::uint64_t kFnv1aOffset = 0xcbf29ce484222325u;

/// The hash of `bytes`, continued from `hash` (http://www.isthe.com/chongo/tech/comp/fnv/).
constexpr std::uint64_t fnv1a(std::span<const std::byte> bytes, std::uint64_t hash = kFnv1aOffset) {
  for (const std::byte b : bytes) hash = (hash ^ static_cast<std::uint64_t>(b)) * 0x100000001b3u;
  return hash;
}

}  // namespace fluxgs
