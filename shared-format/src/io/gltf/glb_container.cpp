#include "io/gltf/glb_container.h"

#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace fluxgs::io {
namespace {

std::uint32_t u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Expected<void> check_header(std::span<const std::byte> bytes, const std::string& name) {
  if (bytes.size() < kGlbHeader + kGlbChunkHeader) {
    return fail(name, "header",
                fmt::format("the file holds {} bytes; a .glb has at least {}", bytes.size(),
                            kGlbHeader + kGlbChunkHeader));
  }
  if (std::memcmp(bytes.data(), kGlbMagic, sizeof kGlbMagic) != 0) {
    return fail(name, "header", "does not begin with \"glTF\"");
  }
  if (const auto version = u32(bytes, 4); version != 2) {
    return fail(name, "header", fmt::format("version {}; expected 2", version));
  }
  if (const auto length = u32(bytes, 8); length != bytes.size()) {
    return fail(name, "header",
                fmt::format("promises {} bytes, but the file holds {}", length, bytes.size()));
  }
  return {};
}

}  // namespace

Expected<GlbChunks> parse_glb_container(std::span<const std::byte> bytes, const std::string& name) {
  if (auto ok = check_header(bytes, name); !ok) return std::unexpected(ok.error());
  GlbChunks chunks;
  std::size_t at = kGlbHeader;
  for (int index = 0; at < bytes.size(); ++index) {
    const std::string field = fmt::format("chunk {}", index);
    const std::size_t left = bytes.size() - at;
    if (left < kGlbChunkHeader) {
      return fail(name, field, fmt::format("{} bytes left; expected a header of 8", left));
    }
    const std::uint32_t length = u32(bytes, at), type = u32(bytes, at + 4);
    if (length % 4 != 0) {
      return fail(name, field, fmt::format("length {} is not a multiple of 4", length));
    }
    if (length > left - kGlbChunkHeader) {
      return fail(name, field,
                  fmt::format("promises {} bytes, but the file holds {} from there on", length,
                              left - kGlbChunkHeader));
    }
    const auto content = bytes.subspan(at + kGlbChunkHeader, length);
    if (index == 0) {
      if (type != kGlbJson) return fail(name, field, "is not JSON; the first chunk must be");
      chunks.json = {reinterpret_cast<const char*>(content.data()), content.size()};
    } else if (index == 1 && type == kGlbBin) {
      chunks.bin = content;
    } else if (type == kGlbJson || type == kGlbBin) {
      return fail(name, field, "is a second JSON or a misplaced BIN chunk");
    }
    at += kGlbChunkHeader + length;
  }
  // Spaces are the padding of the specification; some writers use zeros.
  using namespace std::string_view_literals;
  chunks.json = chunks.json.substr(0, chunks.json.find_last_not_of(" \0"sv) + 1);
  return chunks;
}

}  // namespace fluxgs::io
