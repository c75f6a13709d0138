#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/packing.hpp>

#include "cloud/activation.h"
#include "fluxgs/io/spz.h"
#include "fluxgs/math/sh_rotation.h"
#include "io/spz/spz_compression.h"
#include "io/spz/spz_packed.h"
#include "io/whole_cloud.h"

namespace fluxgs {
namespace io {
namespace {

float byte_value(std::byte b) { return static_cast<float>(std::to_integer<int>(b)); }

float fixed24(const std::byte* at, float scale) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, at, 3);
  const auto value = static_cast<std::int32_t>(bits << 8) >> 8;  // the sign of bit 23
  return static_cast<float>(value) * scale;
}

float half(const std::byte* at) {
  std::uint16_t bits = 0;
  std::memcpy(&bits, at, sizeof bits);
  return glm::unpackHalf1x16(bits);
}

glm::vec3 position(const SpzHeader& header, const std::byte* at) {
  if (header.version == 1) return {half(at), half(at + 2), half(at + 4)};
  const float scale = std::ldexp(1.0f, -header.fractional_bits);
  return {fixed24(at, scale), fixed24(at + 3, scale), fixed24(at + 6, scale)};
}

// Versions 1 and 2: x, y, z; w is what is left to a unit quaternion.
glm::quat first_three(const std::byte* at) {
  const glm::vec3 v(byte_value(at[0]) / 127.5f - 1, byte_value(at[1]) / 127.5f - 1,
                    byte_value(at[2]) / 127.5f - 1);
  return glm::quat(std::sqrt(std::max(0.0f, 1 - glm::dot(v, v))), v.x, v.y, v.z);
}

// Later versions: from the top, 2 bits for the place of the largest component among x, y, z, w, and
// 10 bits (sign, magnitude) for each of the others in that order.
glm::quat smallest_three(const std::byte* at) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, at, sizeof bits);
  const std::uint32_t largest = bits >> 30;
  constexpr float kStep = 0.70710678118654752440f / static_cast<float>(kSpzRotationMost);
  std::array<float, 4> q{};
  float squares = 0;
  for (std::uint32_t i = 4; i-- > 0;) {
    if (i == largest) continue;
    const float magnitude = static_cast<float>(bits & kSpzRotationMost) * kStep;
    q[i] = (bits & (kSpzRotationMost + 1)) != 0 ? -magnitude : magnitude;
    squares += magnitude * magnitude;
    bits >>= 10;
  }
  q[largest] = std::sqrt(std::max(0.0f, 1 - squares));
  return glm::quat(q[3], q[0], q[1], q[2]);
}

const std::array<float, 256>& logits() {
  static const std::array<float, 256> table = logits_of_bytes();
  return table;
}

// Before they are compressed together.
AttributeBits bits_of(const SpzHeader& header) {
  const auto bytes = spz_attribute_bytes(header.version, header.sh_degree);
  const auto bits = [&](SpzAttribute a) { return 8.0 * static_cast<double>(bytes[a]); };
  AttributeBits result{{"position", bits(kSpzPositions)},
                       {"scale", bits(kSpzScales)},
                       {"rotation", bits(kSpzRotations)},
                       {"opacity", bits(kSpzAlphas)},
                       {"sh_dc", bits(kSpzColours)}};
  if (header.sh_degree > 0) result["sh_rest"] = bits(kSpzSh);
  return result;
}

// A quarter about x, from axes right, back, down to right, down, front.
void stand_up(SplatCloud& cloud) {
  const glm::quat turn(glm::angleAxis(-glm::half_pi<float>(), glm::vec3(1, 0, 0)));
  const math::ShRotation sh = math::make_sh_rotation({{1, 0, 0}, {0, 0, 1}, {0, -1, 0}});
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 p = cloud.positions[i];
    cloud.positions[i] = {p.x, p.z, -p.y};
    cloud.rotations[i] = turn * cloud.rotations[i];
    if (rest > 0) math::rotate_sh(sh, cloud.sh_degree, cloud.sh_rest.data() + i * rest);
  }
}

}  // namespace

void read_spz_splat(const SpzPacked& packed, std::size_t i, const AxisFlip& flip,
                    SplatValues& splat) {
  const SpzHeader& header = packed.header;
  const auto bytes = spz_attribute_bytes(header.version, header.sh_degree);
  const auto at = [&](SpzAttribute a) {
    return packed.data.data() + packed.offsets[a] + i * bytes[a];
  };
  splat.position = position(header, at(kSpzPositions)) * flip.position;
  splat.opacity_logit = logits()[std::to_integer<std::size_t>(*at(kSpzAlphas))];
  const std::byte* colour = at(kSpzColours);
  const std::byte* scale = at(kSpzScales);
  for (int c = 0; c < 3; ++c) {
    splat.sh_dc[c] = (byte_value(colour[c]) / 255.0f - 0.5f) / static_cast<float>(kSpzColour);
    splat.log_scale[c] = byte_value(scale[c]) / static_cast<float>(kSpzLogScaleSteps) +
                         static_cast<float>(kSpzLeastLogScale);
  }
  const glm::quat q =
      header.version >= 3 ? smallest_three(at(kSpzRotations)) : first_three(at(kSpzRotations));
  splat.rotation =
      glm::quat(q.w, q.x * flip.rotation.x, q.y * flip.rotation.y, q.z * flip.rotation.z);
  const std::byte* sh = at(kSpzSh);
  const auto rest = static_cast<std::size_t>(sh_rest_count(header.kept_degree()));
  for (std::size_t k = 0; k < rest; ++k, sh += 3) {
    splat.sh_rest[k] =
        glm::vec3(byte_value(sh[0]) - 128, byte_value(sh[1]) - 128, byte_value(sh[2]) - 128) *
        (flip.sh[k] / 128);
  }
}

}  // namespace io

bool is_spz(std::span<const std::byte> bytes) {
  constexpr std::byte kGzip[] = {std::byte{0x1f}, std::byte{0x8b}};
  std::array<std::byte, sizeof io::kSpzMagic> start{};
  if (bytes.size() < start.size()) return false;
  if (std::memcmp(bytes.data(), kGzip, sizeof kGzip) != 0) {
    std::memcpy(start.data(), bytes.data(), start.size());
  } else if (io::inflate_gzip_start(bytes, start).written < start.size()) {
    return false;
  }
  return std::memcmp(start.data(), io::kSpzMagic, start.size()) == 0;
}

Expected<SceneFile> read_spz(std::span<const std::byte> bytes, const std::string& name) {
  return read_spz(bytes, name, SpzAxes::right_down_front);
}

Expected<SceneFile> read_spz(std::span<const std::byte> bytes, const std::string& name,
                             SpzAxes axes) {
  return io::read_whole(name, [&](SplatSink& sink) { return read_spz(bytes, name, sink, axes); });
}

Expected<SceneFile> read_spz(std::span<const std::byte> bytes, const std::string& name,
                             SplatSink& sink, SpzAxes axes) {
  const io::SpzSource source{bytes, name, ""};
  const auto header = io::read_spz_header(source);
  if (!header) return std::unexpected(header.error());
  const ComingSplats coming{
      header->count, header->kept_degree(),
      header->count * io::spz_splat_bytes(header->version, header->sh_degree)};
  const auto degree = sink.begin(coming);
  if (!degree) return std::unexpected(degree.error());
  auto packed = io::unpack_spz(source, *header);
  if (!packed) return std::unexpected(packed.error());
  const io::AxisFlip flip = io::make_axis_flip(
      packed->axes.value_or(axes == SpzAxes::right_up_back ? io::kRightUpBack : glm::vec3(1)));
  const auto rest = static_cast<std::size_t>(sh_rest_count(*degree));
  io::SplatValues splat{};
  SceneFile scene;
  const auto fill = [&](std::size_t first, SplatCloud& part) -> Expected<void> {
    for (std::size_t k = 0; k < part.size(); ++k) {
      io::read_spz_splat(*packed, first + k, flip, splat);
      io::store_splat(splat, rest, part, k);
    }
    if (packed->z_up) io::stand_up(part);
    return {};
  };
  if (auto done = io::hand_on(coming, *degree, name, sink, scene, fill); !done)
    return std::unexpected(done.error());
  scene.cloud.filter = header->filter();
  scene.warnings = std::move(packed->warnings);
  scene.format = "spz";
  scene.attribute_bits = io::bits_of(*header);
  scene.bytes = bytes.size();
  return scene;
}

}  // namespace fluxgs
