#include <algorithm>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

#include "io/spz/spz_compression.h"
#include "io/spz/spz_packed.h"

namespace fluxgs::io {
namespace {

// See spz.h. A scene of random values takes its unpacked size, so that the factor is generous.
constexpr std::size_t kMaxExpansion = 32;
constexpr std::size_t kAlwaysAllowed = std::size_t(1) << 20;

constexpr int kMaxFractionalBits = 24;  // as the reference implementation

std::uint32_t u32(const std::byte* at) {
  std::uint32_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

bool has_magic(const std::byte* at) { return std::memcmp(at, kSpzMagic, sizeof kSpzMagic) == 0; }

// The part that all versions share: version, count, degree, fractional bits, flags.
SpzHeader shared_part(const std::byte* at) {
  SpzHeader header;
  header.version = u32(at + 4);
  header.count = u32(at + 8);
  header.sh_degree = std::to_integer<int>(at[12]);
  header.fractional_bits = std::to_integer<int>(at[13]);
  header.flags = std::to_integer<unsigned>(at[14]);
  return header;
}

Expected<SpzHeader> header_in_gzip(const SpzSource& source) {
  std::array<std::byte, kSpzHeader> start{};
  const Inflated got = inflate_gzip_start(source.bytes, start);
  if (got.written < start.size()) {
    return source.fail("gzip", shortfall(got, start.size()));
  }
  if (!has_magic(start.data())) {
    return source.fail("header", "does not begin with \"NGSP\"");
  }
  SpzHeader header = shared_part(start.data());
  if (header.version < 1 || header.version > 3) {
    return source.fail("header",
                       fmt::format("version {} inside gzip; expected 1 to 3", header.version));
  }
  return header;
}

Expected<SpzHeader> plain_header(const SpzSource& source) {
  const std::span<const std::byte> bytes = source.bytes;
  if (bytes.size() < kSpzHeader4) {
    return source.fail("header", fmt::format("{} bytes; a file of version 4 has at least {}",
                                             bytes.size(), kSpzHeader4));
  }
  SpzHeader header = shared_part(bytes.data());
  if (header.version != 4) {
    return source.fail("header",
                       fmt::format("version {} outside of gzip; expected 4", header.version));
  }
  header.streams = std::to_integer<std::size_t>(bytes[15]);
  header.contents = u32(bytes.data() + 16);
  return header;
}

Expected<void> check_values(const SpzSource& source, const SpzHeader& header) {
  if (header.sh_degree > kSpzMaxDegree) {
    return source.fail("header", fmt::format("degree {} of spherical harmonics; expected 0 to {}",
                                             header.sh_degree, kSpzMaxDegree));
  }
  if (header.fractional_bits > kMaxFractionalBits) {
    return source.fail("header", fmt::format("{} fractional bits; expected 0 to {}",
                                             header.fractional_bits, kMaxFractionalBits));
  }
  return {};
}

Expected<void> check_count(const SpzSource& source, const SpzHeader& header) {
  // No overflow: the count has 32 bits.
  const std::uint64_t unpacked =
      std::uint64_t{header.count} * spz_splat_bytes(header.version, header.sh_degree);
  if (header.count <= kAlwaysAllowed || unpacked / kMaxExpansion <= source.bytes.size()) return {};
  return source.fail("header",
                     fmt::format("promises {} splats of {} bytes together, compressed to {} bytes; "
                                 "expected at most {} times as much",
                                 header.count, unpacked, source.bytes.size(), kMaxExpansion));
}

}  // namespace

Expected<SpzHeader> read_spz_header(const SpzSource& source) {
  const std::span<const std::byte> bytes = source.bytes;
  const bool plain = bytes.size() >= sizeof kSpzMagic && has_magic(bytes.data());
  auto header = plain ? plain_header(source) : header_in_gzip(source);
  if (!header) return header;
  if (auto ok = check_values(source, *header); !ok) return std::unexpected(ok.error());
  if (auto ok = check_count(source, *header); !ok) return std::unexpected(ok.error());
  return header;
}

}  // namespace fluxgs::io
