// The framing of a .glb (glTF 2.0 specification, section 4.4), checked before any parser sees it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// The two chunks of a .glb, as views of the file's bytes.
struct GlbChunks {
  std::string_view json;           ///< without the padding behind it
  std::span<const std::byte> bin;  ///< empty if there is no such chunk
};

/// Magic, version, length and every chunk's length and type. Chunks of unknown type after the first
/// two are skipped, as the specification asks.
Expected<GlbChunks> parse_glb_container(std::span<const std::byte> bytes, const std::string& name);

inline constexpr std::size_t kGlbHeader = 12, kGlbChunkHeader = 8;
inline constexpr char kGlbMagic[] = {'g', 'l', 'T', 'F'};
inline constexpr unsigned kGlbJson = 0x4E4F534A, kGlbBin = 0x004E4942;

}  // namespace fluxgs::io
