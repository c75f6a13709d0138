#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"
#include "fluxgs/io/spz.h"
#include "io/spz/spz_compression.h"
#include "io/spz/spz_layout.h"

namespace fluxgs {
namespace {

using namespace io;

constexpr double kMaxPosition = (1 << 23) - 1;
constexpr int kMaxFractionalBits = 23;

Expected<void> check_options(const SpzOptions& options, const std::string& name) {
  const auto outside = [&](const char* what, int value, int least, int most) {
    return fail(name, what, fmt::format("is {}; expected {} to {}", value, least, most));
  };
  if (options.version != 3 && options.version != 4)
    return outside("version", options.version, 3, 4);
  if (options.fractional_bits < 0 || options.fractional_bits > kMaxFractionalBits) {
    return outside("fractional_bits", options.fractional_bits, 0, kMaxFractionalBits);
  }
  for (const auto& [what, bits] :
       {std::pair("sh1_bits", options.sh1_bits), std::pair("sh_rest_bits", options.sh_rest_bits)}) {
    if (bits < 1 || bits > 8) return outside(what, bits, 1, 8);
  }
  return {};
}

// As many fractional bits as asked for, fewer if the farthest position needs more in front.
Expected<int> choose_fractional_bits(const SplatCloud& cloud, int wanted, const std::string& name) {
  double farthest = 0;
  for (const glm::vec3& p : cloud.positions) {
    for (int c = 0; c < 3; ++c) farthest = std::max(farthest, std::abs(double{p[c]}));
  }
  int bits = wanted;
  while (bits > 0 && std::round(std::ldexp(farthest, bits)) > kMaxPosition) --bits;
  if (std::round(farthest) <= kMaxPosition) return bits;
  return fail(
      name, "positions",
      fmt::format("reach {} from the origin; SPZ holds at most {}", farthest, kMaxPosition));
}

std::byte to_byte(double value) {
  return static_cast<std::byte>(std::clamp(std::round(value), 0.0, 255.0));
}

void put_position(const glm::vec3& p, const AxisFlip& flip, int fractional_bits, std::byte* out) {
  for (int c = 0; c < 3; ++c, out += 3) {
    const double value = double{p[c]} * double{flip.position[c]};
    const auto fixed = static_cast<std::int32_t>(std::round(std::ldexp(value, fractional_bits)));
    std::memcpy(out, &fixed, 3);
  }
}

// See smallest_three in spz_read.cpp. A zero quaternion counts as no rotation.
void put_rotation(const glm::quat& rotation, const AxisFlip& flip, std::byte* out) {
  double q[4] = {double{rotation.x} * double{flip.rotation.x},
                 double{rotation.y} * double{flip.rotation.y},
                 double{rotation.z} * double{flip.rotation.z}, rotation.w};
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (length == 0) q[3] = 1;
  const auto largest = static_cast<std::uint32_t>(
      std::ranges::max_element(q, {}, [](double v) { return std::abs(v); }) - q);
  // q and -q are the same rotation; the largest component is the positive one.
  const double unit = std::copysign(length == 0 ? 1 : 1 / length, q[largest]);
  std::uint32_t bits = largest;
  for (std::uint32_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double scaled = q[i] * unit * std::sqrt(2.0) * kSpzRotationMost;
    const auto magnitude = std::min(static_cast<std::uint32_t>(std::round(std::abs(scaled))),
                                    std::uint32_t{kSpzRotationMost});
    const std::uint32_t sign = scaled < 0 && magnitude > 0 ? 1 : 0;  // zero has one form
    bits = bits << 10 | sign << 9 | magnitude;
  }
  std::memcpy(out, &bits, sizeof bits);
}

// A value of -1…1 in 256 steps, rounded so that only `bits` of its 8 bits vary.
std::byte sh(float value, int bits) {
  const double step = 1 << (8 - bits);
  return to_byte(128 + step * std::round(double{value} * 128 / step));
}

// Writes the attributes of all splats one after the other, as they stand in all versions.
void pack(const SplatCloud& cloud, const SpzOptions& options, int fractional_bits, std::byte* out) {
  const auto bytes = spz_attribute_bytes(static_cast<unsigned>(options.version), cloud.sh_degree);
  std::array<std::byte*, kSpzAttributes> to{};
  for (std::size_t a = 0; a < kSpzAttributes; ++a) {
    to[a] = out;
    out += cloud.size() * bytes[a];
  }
  const AxisFlip flip =
      make_axis_flip(options.axes == SpzAxes::right_up_back ? kRightUpBack : glm::vec3(1));
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put_position(cloud.positions[i], flip, fractional_bits, to[kSpzPositions] + 9 * i);
    to[kSpzAlphas][i] = to_byte(255 / (1 + std::exp(-double{cloud.opacity_logits[i]})));
    put_rotation(cloud.rotations[i], flip, to[kSpzRotations] + 4 * i);
    for (int c = 0; c < 3; ++c) {
      const std::size_t at = 3 * i + static_cast<std::size_t>(c);
      to[kSpzColours][at] = to_byte(255 * (double{cloud.sh_dc[i][c]} * kSpzColour + 0.5));
      to[kSpzScales][at] =
          to_byte((double{cloud.log_scales[i][c]} - kSpzLeastLogScale) * kSpzLogScaleSteps);
      for (std::size_t k = 0; k < rest; ++k) {
        to[kSpzSh][3 * (i * rest + k) + static_cast<std::size_t>(c)] =
            sh(cloud.sh_rest[i * rest + k][c] * flip.sh[k],
               k < 3 ? options.sh1_bits : options.sh_rest_bits);
      }
    }
  }
}

// The 16 bytes that all versions begin with; the last one is reserved in version 3 and the number
// of streams in version 4.
void put_header(const SplatCloud& cloud, const SpzOptions& options, int fractional_bits,
                std::size_t last, std::byte* out) {
  const std::uint32_t numbers[] = {static_cast<std::uint32_t>(options.version),
                                   static_cast<std::uint32_t>(cloud.size())};
  std::memcpy(out, kSpzMagic, sizeof kSpzMagic);
  std::memcpy(out + 4, numbers, sizeof numbers);
  out[12] = static_cast<std::byte>(cloud.sh_degree);
  out[13] = static_cast<std::byte>(fractional_bits);
  out[14] = std::byte{0};
  out[15] = static_cast<std::byte>(last);
}

// Version 4: header, table of contents, one zstd stream for each attribute that has bytes.
Expected<std::vector<std::byte>> encode_streams(const SplatCloud& cloud, const SpzOptions& options,
                                                int fractional_bits,
                                                std::span<const std::byte> packed,
                                                const std::string& name) {
  std::vector<std::vector<std::byte>> streams;
  std::vector<std::uint64_t> sizes;  // compressed, uncompressed, …
  std::size_t total = 0;
  for (const std::size_t each :
       spz_attribute_bytes(static_cast<unsigned>(options.version), cloud.sh_degree)) {
    const auto attribute = packed.first(cloud.size() * each);
    packed = packed.subspan(attribute.size());
    if (attribute.empty()) continue;
    auto stream = compress_zstd(attribute, name);
    if (!stream) return stream;
    sizes.insert(sizes.end(), {stream->size(), attribute.size()});
    total += stream->size();
    streams.push_back(std::move(*stream));
  }
  const std::size_t table = streams.size() * kSpzStreamEntry;
  auto bytes = allocate_bytes(kSpzHeader4 + table + total, name);
  if (!bytes) return bytes;
  std::byte* out = bytes->data();
  put_header(cloud, options, fractional_bits, streams.size(), out);
  constexpr auto kContents = static_cast<std::uint32_t>(kSpzHeader4);
  std::memcpy(out + kSpzHeader, &kContents, sizeof kContents);
  out += kSpzHeader4;
  if (table > 0) std::memcpy(out, sizes.data(), table);
  out += table;
  for (const auto& stream : streams) out = std::ranges::copy(stream, out).out;
  return bytes;
}

}  // namespace

Expected<std::vector<std::byte>> encode_spz(const SplatCloud& cloud, const std::string& name,
                                            const SpzOptions& options) {
  if (auto ok = check_options(options, name); !ok) return std::unexpected(ok.error());
  SplatCloud storage;
  const auto finite = writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  const SplatCloud& splats = **finite;
  if (splats.size() > std::numeric_limits<std::uint32_t>::max()) {
    return fail(name, "scene", fmt::format("{} splats; SPZ counts in 32 bits", splats.size()));
  }
  const auto fractional_bits = choose_fractional_bits(splats, options.fractional_bits, name);
  if (!fractional_bits) return std::unexpected(fractional_bits.error());
  const std::size_t each =
      spz_splat_bytes(static_cast<unsigned>(options.version), splats.sh_degree);
  auto plain = allocate_bytes(kSpzHeader + splats.size() * each, name);
  if (!plain) return plain;
  pack(splats, options, *fractional_bits, plain->data() + kSpzHeader);
  if (options.version == 4) {
    return encode_streams(splats, options, *fractional_bits, std::span(*plain).subspan(kSpzHeader),
                          name);
  }
  put_header(splats, options, *fractional_bits, 0, plain->data());
  return compress_gzip(*plain, name);
}

Expected<std::vector<std::byte>> encode_spz(const SplatCloud& cloud, const std::string& name) {
  return encode_spz(cloud, name, SpzOptions{});
}

}  // namespace fluxgs
