// The framing of a .glb (glTF 2.0 specification, section 4.4), checked before any parser sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"

namespace fluxgs::io {

/// The two chunks of a .glb.
struct GlbChunks {
  std::string_view json;                    ///< without the padding behind it
  std::uint64_t bin_at = 0, bin_bytes = 0;  ///< place in the file; zeros if there is none
  std::uint64_t behind = 0;                 ///< where others would begin
};

/// True if it has the magic of a .glb.
Expected<bool> begins_as_glb(const ByteSource& file);

/// Magic, version, length and the lengths and types of the first two chunks. Of the file no more is
/// read than the first chunk, which lies in `room` or in the source, and the next header.
Expected<GlbChunks> parse_glb_container(const ByteSource& file, const std::string& name,
                                        std::vector<std::byte>& room);

/// The chunks behind those two, which are of unknown type and skipped, as the specification asks.
Expected<void> check_chunks_behind(const ByteSource& file, const GlbChunks& chunks,
                                   const std::string& name);

inline constexpr std::size_t kGlbHeader = 12, kGlbChunkHeader = 8;
inline constexpr char kGlbMagic[] = {'g', 'l', 'T', 'F'};
inline constexpr unsigned kGlbJson = 0x4E4F534A, kGlbBin = 0x004E4942;

}  // namespace fluxgs::io
