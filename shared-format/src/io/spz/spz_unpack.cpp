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
template <class T>
T load(const std::byte* at) {
  T value{};
  std::memcpy(&value, at, sizeof value);
  return value;
}

// Codes 1…8: a bit each for right, up and front of the first, second and third axis. 9…16: right,
// back and up, of which the latter two change places by a quarter about x.
void follow_axes(std::uint32_t code, SpzPacked& packed) {
  const std::uint32_t bits = (code - 1) & 7;
  const auto sign = [&](unsigned bit, float set) { return (bits & bit) != 0 ? set : -set; };
  packed.z_up = code > 8;
  packed.axes = packed.z_up ? glm::vec3(sign(1, 1), sign(4, 1), sign(2, -1))
                            : glm::vec3(sign(1, 1), sign(2, -1), sign(4, 1));
}

void read_record(std::uint32_t type, std::span<const std::byte> payload, SpzPacked& packed) {
  constexpr std::uint32_t kMostCode = 16;
  if (type != kSpzAxesRecord) return;  // the specification asks to skip unknown ones
  const std::uint32_t code = payload.size() == 4 ? load<std::uint32_t>(payload.data()) : 0;
  if (code > 0 && code <= kMostCode) return follow_axes(code, packed);
  packed.warnings.push_back(fmt::format(
      "its record SPZ_ADOBE_coordinate_system names no axes ({} bytes, code {}), and is ignored",
      payload.size(), code));
}

// Records of type, length and payload (extensions/README of nianticlabs/spz). The splats do not
// depend on them, so that damaged ones are left out.
void read_extensions(std::span<const std::byte> records, SpzPacked& packed) {
  while (!records.empty()) {
    const std::size_t left = records.size();
    const auto length = left < 8 ? 0 : load<std::uint32_t>(records.data() + 4);
    if (left < 8 || length > left - 8) {
      packed.warnings.push_back(
          fmt::format("its extension records are damaged; the last {} bytes are ignored", left));
      return;
    }
    read_record(load<std::uint32_t>(records.data()), records.subspan(8, length), packed);
    records = records.subspan(8 + std::size_t{length});
  }
}

void warn_of_header(const SpzHeader& header, SpzPacked& packed) {
  if (const unsigned unknown = header.flags & ~(kSpzAntialiased | kSpzExtensions))
    packed.warnings.push_back(
        fmt::format("its header has unknown flags ({:#x}), which are ignored", unknown));
  if (header.sh_degree > header.kept_degree())
    packed.warnings.push_back(
        fmt::format("spherical harmonics beyond degree {} are left out", header.kept_degree()));
}

// Behind the data there may be the padding of a glTF buffer view.
void check_rest(std::span<const std::byte> rest, SpzPacked& packed) {
  if (rest.size() < 4 && std::ranges::all_of(rest, [](std::byte b) { return b == std::byte{}; }))
    return;
  packed.warnings.push_back(
      fmt::format("{} bytes behind its compressed data are ignored", rest.size()));
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
    return source.fail("gzip", shortfall(got, expected));
  }
  check_rest(source.bytes.subspan(got.consumed), packed);
  packed.data = std::move(*bytes);
  for (std::size_t& offset : packed.offsets) offset += kSpzHeader;
  if (extended)
    read_extensions(std::span(packed.data).subspan(expected, got.written - expected), packed);
  return {};
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
    return source.fail(field, fmt::format("takes {} bytes, but {} are left: the file is cut off",
                                          compressed, source.bytes.size() - at));
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
    read_extensions(source.bytes.subspan(kSpzHeader4, header.contents - kSpzHeader4), packed);
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
  check_rest(source.bytes.subspan(at), packed);
  return {};
}

}  // namespace

Expected<SpzPacked> unpack_spz(const SpzSource& source, const SpzHeader& header) {
  SpzPacked packed;
  packed.header = header;
  warn_of_header(header, packed);
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
