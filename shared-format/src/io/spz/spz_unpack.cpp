#include <algorithm>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"
#include "io/spz/spz_compression.h"
#include "io/spz/spz_packed.h"

namespace fluxgs::io {
namespace {

// Room for the extension records behind the splats of versions 1 to 3; the known ones have 12 to 20
// bytes.
constexpr std::size_t kMaxExtensions = 65536;
constexpr std::uint32_t kAxesExtension = 0xADBE0003;  // SPZ_ADOBE_coordinate_system

template <class T>
T load(const std::byte* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return value;
}

// The axes' codes 1…8 of the extension are a bit each for right, up and front; 9…16 are turned by a
// quarter about x as well. 0 is "unspecified".
Expected<void> follow_axes(const SpzSource& source, std::span<const std::byte> payload,
                           std::optional<glm::vec3>& axes) {
  if (payload.size() != 4) {
    return source.fail("SPZ_ADOBE_coordinate_system",
                       fmt::format("{} bytes; expected 4", payload.size()));
  }
  const auto code = load<std::uint32_t>(payload.data());
  if (code > 8) {
    return source.fail(
        "SPZ_ADOBE_coordinate_system",
        fmt::format("axes {} are not supported; expected 0 to 8 (y up or down)", code));
  }
  if (code == 0) return {};
  const std::uint32_t bits = code - 1;
  axes = glm::vec3((bits & 1) != 0 ? 1 : -1, (bits & 2) != 0 ? -1 : 1, (bits & 4) != 0 ? 1 : -1);
  return {};
}

// Records of type, length and payload (extensions/README of nianticlabs/spz). Unknown ones are
// skipped, as the specification asks.
Expected<void> read_extensions(const SpzSource& source, std::span<const std::byte> records,
                               std::optional<glm::vec3>& axes) {
  while (!records.empty()) {
    if (records.size() < 8) {
      return source.fail(
          "extensions", fmt::format("{} bytes left; expected a type and a length", records.size()));
    }
    const auto type = load<std::uint32_t>(records.data());
    const auto length = load<std::uint32_t>(records.data() + 4);
    records = records.subspan(8);
    if (length > records.size()) {
      return source.fail("extensions",
                         fmt::format("type {:#010x} promises {} bytes, but {} are left", type,
                                     length, records.size()));
    }
    if (type == kAxesExtension) {
      if (auto ok = follow_axes(source, records.first(length), axes); !ok) return ok;
    }
    records = records.subspan(length);
  }
  return {};
}

// Behind the data there may be the padding of a glTF buffer view, nothing else.
Expected<void> check_rest(const SpzSource& source, std::span<const std::byte> rest) {
  if (rest.size() < 4 && std::ranges::all_of(rest, [](std::byte b) { return b == std::byte{}; })) {
    return {};
  }
  return source.fail(
      "end", fmt::format("{} bytes behind the compressed data; expected none", rest.size()));
}

Expected<void> unpack_gzip(const SpzSource& source, SpzPacked& packed, std::size_t splats) {
  const std::size_t expected = kSpzHeader + splats;
  const bool extended = (packed.header.flags & kSpzExtensions) != 0;
  const std::size_t most = expected + (extended ? kMaxExtensions : 0);
  // One byte more than there may be, to notice it.
  auto bytes = allocate_bytes(most + 1, source.name);
  if (!bytes) return std::unexpected(bytes.error());
  const Inflated got = inflate_gzip(source.bytes, *bytes);
  if (got.written > most) {
    return source.fail("gzip",
                       fmt::format("holds more than the {} bytes that the header promises", most));
  }
  if (got.damaged || !got.ended || got.written < expected) {
    return source.fail(
        "gzip", fmt::format("{} after {} bytes; expected {}", got.damaged ? "is damaged" : "ends",
                            got.written, expected));
  }
  if (auto ok = check_rest(source, source.bytes.subspan(got.consumed)); !ok) return ok;
  packed.data = std::move(*bytes);
  for (std::size_t& offset : packed.offsets) offset += kSpzHeader;
  if (!extended) return {};
  return read_extensions(source, std::span(packed.data).subspan(expected, got.written - expected),
                         packed.axes);
}

Expected<void> check_contents(const SpzSource& source, const SpzHeader& header,
                              std::size_t streams) {
  if (header.streams != streams) {
    return source.fail("header", fmt::format("{} streams; expected {}", header.streams, streams));
  }
  const std::size_t size = source.bytes.size(), table = streams * kSpzStreamEntry;
  if (header.contents < kSpzHeader4 || header.contents > size || table > size - header.contents) {
    return source.fail("header", fmt::format("a table of {} streams at {} is outside the {} bytes",
                                             streams, header.contents, size));
  }
  return {};
}

// One attribute of version 4: its sizes in the table, its data at `at`, which moves on.
Expected<void> unpack_stream(const SpzSource& source, const std::byte* entry, std::size_t& at,
                             std::span<std::byte> out, const std::string& field) {
  const auto compressed = load<std::uint64_t>(entry), promised = load<std::uint64_t>(entry + 8);
  if (promised != out.size()) {
    return source.fail(field, fmt::format("promises {} bytes; the splats of the header take {}",
                                          promised, out.size()));
  }
  if (compressed > source.bytes.size() - at) {
    return source.fail(field, fmt::format("takes {} bytes, but {} are left", compressed,
                                          source.bytes.size() - at));
  }
  const auto input = source.bytes.subspan(at, static_cast<std::size_t>(compressed));
  if (const std::string reason = decompress_zstd(input, out); !reason.empty()) {
    return source.fail(field, "zstd: " + reason);
  }
  at += input.size();
  return {};
}

Expected<void> unpack_zstd(const SpzSource& source, SpzPacked& packed, std::size_t splats) {
  const SpzHeader& header = packed.header;
  const auto bytes_each = spz_attribute_bytes(header.version, header.sh_degree);
  // Attributes without bytes have no stream.
  const auto streams = static_cast<std::size_t>(std::ranges::count_if(
      bytes_each, [&](std::size_t bytes) { return header.count * bytes > 0; }));
  if (auto ok = check_contents(source, header, streams); !ok) return ok;
  if ((header.flags & kSpzExtensions) != 0) {
    const auto records = source.bytes.subspan(kSpzHeader4, header.contents - kSpzHeader4);
    if (auto ok = read_extensions(source, records, packed.axes); !ok) return ok;
  }
  auto data = allocate_bytes(splats, source.name);
  if (!data) return std::unexpected(data.error());
  packed.data = std::move(*data);
  const std::byte* entry = source.bytes.data() + header.contents;
  std::size_t at = header.contents + streams * kSpzStreamEntry, stream = 0;
  for (std::size_t a = 0; a < kSpzAttributes; ++a) {
    if (header.count * bytes_each[a] == 0) continue;
    const auto out =
        std::span(packed.data).subspan(packed.offsets[a], header.count * bytes_each[a]);
    const std::string field = fmt::format("stream {}", stream++);
    if (auto ok = unpack_stream(source, entry, at, out, field); !ok) return ok;
    entry += kSpzStreamEntry;
  }
  return check_rest(source, source.bytes.subspan(at));
}

}  // namespace

Expected<SpzPacked> unpack_spz(const SpzSource& source, const SpzHeader& header) {
  SpzPacked packed;
  packed.header = header;
  std::size_t splats = 0;
  const auto bytes_each = spz_attribute_bytes(header.version, header.sh_degree);
  for (std::size_t a = 0; a < kSpzAttributes; ++a) {
    packed.offsets[a] = splats;
    splats += header.count * bytes_each[a];
  }
  const auto done = header.version >= 4 ? unpack_zstd(source, packed, splats)
                                        : unpack_gzip(source, packed, splats);
  if (!done) return std::unexpected(done.error());
  return packed;
}

}  // namespace fluxgs::io
