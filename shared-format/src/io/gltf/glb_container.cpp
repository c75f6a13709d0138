#include "io/gltf/glb_container.h"

#include <algorithm>
#include <cstring>
#include <span>

#include <fmt/format.h>

#include "io/json_text.h"

namespace fluxgs::io {
namespace {

std::uint32_t u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Expected<void> check_header(const ByteSource& file, const std::string& name) {
  std::vector<std::byte> room;
  const std::uint64_t size = file.size();
  const auto bytes = file.read(0, std::min<std::uint64_t>(size, kGlbHeader), room);
  if (!bytes) return std::unexpected(bytes.error());
  if (size < kGlbHeader + kGlbChunkHeader) {
    return fail(name, "header",
                fmt::format("the file holds {} bytes; a .glb has at least {}", size,
                            kGlbHeader + kGlbChunkHeader));
  }
  if (std::memcmp(bytes->data(), kGlbMagic, sizeof kGlbMagic) != 0) {
    return fail(name, "header", "does not begin with \"glTF\"");
  }
  if (const auto version = u32(*bytes, 4); version != 2) {
    return fail(name, "header", fmt::format("version {}; expected 2", version));
  }
  if (const auto length = u32(*bytes, 8); length != size) {
    return fail(name, "header",
                fmt::format("promises {} bytes, but the file holds {}", length, size));
  }
  return {};
}

struct Chunk {
  std::uint64_t at = 0;  ///< of the content
  std::uint32_t length = 0, type = 0;
  std::uint64_t end() const { return at + length; }
};

/// The chunk whose header is at `at`, before the end of the file.
Expected<Chunk> chunk_at(std::uint64_t at, const ByteSource& file, const std::string& name,
                         const std::string& field) {
  const std::uint64_t left = file.size() - at;
  if (left < kGlbChunkHeader) {
    return fail(name, field, fmt::format("{} bytes left; expected a header of 8", left));
  }
  std::vector<std::byte> room;
  const auto header = file.read(at, kGlbChunkHeader, room);
  if (!header) return std::unexpected(header.error());
  const Chunk chunk{at + kGlbChunkHeader, u32(*header, 0), u32(*header, 4)};
  if (chunk.length % 4 != 0) {
    return fail(name, field, fmt::format("length {} is not a multiple of 4", chunk.length));
  }
  if (chunk.length > left - kGlbChunkHeader) {
    return fail(name, field,
                fmt::format("promises {} bytes, but the file holds {} from there on", chunk.length,
                            left - kGlbChunkHeader));
  }
  return chunk;
}

std::unexpected<Error> misplaced(const std::string& name, const std::string& field) {
  return fail(name, field, "is a second JSON or a misplaced BIN chunk");
}

}  // namespace

Expected<bool> begins_as_glb(const ByteSource& file) {
  std::vector<std::byte> room;
  if (file.size() < sizeof kGlbMagic) return false;
  const auto begin = file.read(0, sizeof kGlbMagic, room);
  if (!begin) return std::unexpected(begin.error());
  return std::memcmp(begin->data(), kGlbMagic, sizeof kGlbMagic) == 0;
}

Expected<GlbChunks> parse_glb_container(const ByteSource& file, const std::string& name,
                                        std::vector<std::byte>& room) {
  if (auto ok = check_header(file, name); !ok) return std::unexpected(ok.error());
  const auto json = chunk_at(kGlbHeader, file, name, "chunk 0");
  if (!json) return std::unexpected(json.error());
  if (json->type != kGlbJson) return fail(name, "chunk 0", "is not JSON; the first chunk must be");
  const auto text = file.read(json->at, json->length, room);
  if (!text) return std::unexpected(text.error());
  GlbChunks chunks{.json = as_text(*text)};
  // Spaces are the padding of the specification; some writers use zeros.
  using namespace std::string_view_literals;
  chunks.json = chunks.json.substr(0, chunks.json.find_last_not_of(" \0"sv) + 1);
  chunks.behind = json->end();
  if (chunks.behind == file.size()) return chunks;
  const auto next = chunk_at(chunks.behind, file, name, "chunk 1");
  if (!next) return std::unexpected(next.error());
  if (next->type == kGlbJson) return misplaced(name, "chunk 1");
  if (next->type == kGlbBin) {
    chunks.bin_at = next->at;
    chunks.bin_bytes = next->length;
    chunks.behind = next->end();
  }
  return chunks;
}

Expected<void> check_chunks_behind(const ByteSource& file, const GlbChunks& chunks,
                                   const std::string& name) {
  std::uint64_t at = chunks.behind;
  for (int index = chunks.bin_at > 0 ? 2 : 1; at < file.size(); ++index) {
    const std::string field = fmt::format("chunk {}", index);
    const auto chunk = chunk_at(at, file, name, field);
    if (!chunk) return std::unexpected(chunk.error());
    if (chunk->type == kGlbJson || chunk->type == kGlbBin) return misplaced(name, field);
    at = chunk->end();
  }
  return {};
}

}  // namespace fluxgs::io
