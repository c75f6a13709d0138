#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "cloud/cloud_memory.h"
#include "fluxgs/io/spz.h"
#include "io/splat/scene_core.h"
#include "io/splat/smallest_three.h"
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

// The farthest that positions of so many fractional bits may be; rounding adds less than a step.
double farthest(int fractional_bits) { return std::ldexp(kMaxPosition - 1, -fractional_bits); }

std::vector<std::size_t> beyond(const SplatCloud& cloud, double limit) {
  std::vector<std::size_t> far;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = glm::abs(cloud.positions[i]);
    if (std::max({p.x, p.y, p.z}) > limit) far.push_back(i);
  }
  return far;
}

// The most fractional bits, up to those asked for, with which few splats are beyond.
std::optional<int> choose_fractional_bits(const SplatCloud& cloud, const SceneCore& core,
                                          int wanted) {
  constexpr std::size_t kFew = 100;  // one of so many
  const glm::dvec3 center = glm::abs(core.center);
  for (int bits = wanted; bits >= 0; --bits) {
    const double limit = farthest(bits);
    if (std::max({center.x, center.y, center.z}) > limit) continue;
    if (kFew * beyond(cloud, limit).size() <= cloud.size()) return bits;
  }
  return std::nullopt;
}

// The bits of positions; pulls in the splats of `cloud`, copied to `storage`, that are beyond.
Expected<int> fit_positions(const SplatCloud*& cloud, SplatCloud& storage,
                            const SpzOptions& options, const std::string& name) {
  const auto far = beyond(*cloud, farthest(options.fractional_bits));
  if (far.empty()) return options.fractional_bits;
  const SceneCore core = scene_core(cloud->positions);
  const auto bits = choose_fractional_bits(*cloud, core, options.fractional_bits);
  if (!bits)
    return fail(name, "positions",
                fmt::format("many are farther than {} from the origin; expected SPZ's range",
                            kMaxPosition));
  const double limit = farthest(*bits);
  if (cloud != &storage) storage = *cloud;
  std::size_t pulled = 0;
  for (const std::size_t i : far) {
    const double factor = factor_within(storage.positions[i], core, limit);
    if (factor < 1) pull_in(storage, i, core, factor), ++pulled;
  }
  cloud = &storage;
  if (pulled > 0 && options.warn)
    options.warn(fmt::format(
        "{} of {} splats are farther than {:.0f} from the origin; they were moved nearer and made "
        "as much smaller, so that the positions of the others keep steps of {:.2g}",
        pulled, cloud->size(), limit, std::ldexp(1.0, -*bits)));
  return *bits;
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
  const io::SmallestThree parts = io::to_smallest_three(
      {double{rotation.x} * double{flip.rotation.x}, double{rotation.y} * double{flip.rotation.y},
       double{rotation.z} * double{flip.rotation.z}, rotation.w},
      3);
  auto bits = static_cast<std::uint32_t>(parts.largest);
  for (const double c : parts.others) {
    const double scaled = c * std::sqrt(2.0) * kSpzRotationMost;
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

// The extension records: which axes the positions have.
std::vector<std::byte> records(const SpzOptions& options) {
  if (!options.name_axes) return {};
  const std::uint32_t record[] = {
      kSpzAxesRecord, sizeof(std::uint32_t),
      options.axes == SpzAxes::right_up_back ? kSpzCodeRub : kSpzCodeRdf};
  const auto bytes = std::as_bytes(std::span(record));
  return {bytes.begin(), bytes.end()};
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
  const unsigned antialiased = cloud.filter.compensated ? kSpzAntialiased : 0;
  out[14] = static_cast<std::byte>(antialiased | (options.name_axes ? kSpzExtensions : 0));
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
  const auto extensions = records(options);
  const std::size_t contents = kSpzHeader4 + extensions.size();
  auto bytes = allocate_bytes(contents + table + total, name);
  if (!bytes) return bytes;
  std::byte* out = bytes->data();
  put_header(cloud, options, fractional_bits, streams.size(), out);
  const auto stored_contents = static_cast<std::uint32_t>(contents);
  std::memcpy(out + kSpzHeader, &stored_contents, sizeof stored_contents);
  out = std::ranges::copy(extensions, out + kSpzHeader4).out;
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
  const SplatCloud* fitting = *finite;
  if (fitting->size() > std::numeric_limits<std::uint32_t>::max()) {
    return fail(name, "scene", fmt::format("{} splats; SPZ counts in 32 bits", fitting->size()));
  }
  const auto fractional_bits = fit_positions(fitting, storage, options, name);
  if (!fractional_bits) return std::unexpected(fractional_bits.error());
  const SplatCloud& splats = *fitting;
  const auto extensions = options.version == 4 ? std::vector<std::byte>() : records(options);
  const std::size_t packed =
      kSpzHeader +
      splats.size() * spz_splat_bytes(static_cast<unsigned>(options.version), splats.sh_degree);
  auto plain = allocate_bytes(packed + extensions.size(), name);
  if (!plain) return plain;
  pack(splats, options, *fractional_bits, plain->data() + kSpzHeader);
  if (options.version == 4) {
    return encode_streams(splats, options, *fractional_bits, std::span(*plain).subspan(kSpzHeader),
                          name);
  }
  put_header(splats, options, *fractional_bits, 0, plain->data());
  std::ranges::copy(extensions, plain->data() + packed);
  return compress_gzip(*plain, name);
}

Expected<std::vector<std::byte>> encode_spz(const SplatCloud& cloud, const std::string& name) {
  return encode_spz(cloud, name, SpzOptions{});
}

Expected<std::vector<std::byte>> write_spz(const SplatCloud& cloud, const std::string& name,
                                           const WriteOptions& options) {
  SpzOptions spz;
  spz.version = options.spz_version;
  spz.warn = options.warn;
  return encode_spz(cloud, name, spz);
}

}  // namespace fluxgs
