#include <algorithm>
#include <cmath>
#include <cstring>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "fluxgs/io/splat.h"
#include "fluxgs/math/projection.h"
#include "io/splat/splat_record.h"

namespace fluxgs {
namespace {

using namespace io;

// Levels w, x, y, z, not yet limited to 0…255.
std::array<double, 4> levels_of(const math::Quat<double>& q) {
  const auto level = [](double component) { return (component + 1) * kSplatRotationOne; };
  return {level(q.w), level(q.x), level(q.y), level(q.z)};
}

std::array<double, 4> rotation_levels(const glm::quat& rotation) {
  const math::Quat<double> q{rotation.w, rotation.x, rotation.y, rotation.z};
  const auto levels = levels_of(q);
  // A quaternion that comes from a .splat is a unit only but for its rounding. Normalising it again
  // could move a level, so it stays as it is.
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const bool whole =
      std::ranges::all_of(levels, [](double level) { return level == std::floor(level); });
  if (whole && std::abs(length - 1) <= kSplatLengthTolerance) return levels;
  return levels_of(math::normalized(q));
}

SplatRecord record_of(const SplatCloud& cloud, std::size_t i) {
  SplatRecord record;
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    record.position[k] = cloud.positions[i][c];
    record.scale[k] = linear_scale(cloud.log_scales[i][c]);
    record.colour[k] = byte_of(colour_of(cloud.sh_dc[i][c]));
  }
  record.colour[3] = byte_of(opacity_of(cloud.opacity_logits[i]));
  const auto levels = rotation_levels(cloud.rotations[i]);
  for (std::size_t k = 0; k < levels.size(); ++k) {
    record.rotation[k] = static_cast<std::uint8_t>(std::lround(std::clamp(levels[k], 0.0, 255.0)));
  }
  return record;
}

}  // namespace

Expected<std::vector<std::byte>> encode_splat(const SplatCloud& cloud, const std::string& name) {
  SplatCloud storage;
  const auto finite = writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  const SplatCloud& splats = **finite;
  if (splats.size() == 0) {
    return fail(name, "scene", "has no splats; a .splat holds at least one (other formats none)");
  }
  auto bytes = allocate_bytes(splats.size() * sizeof(SplatRecord), name);
  if (!bytes) return bytes;
  for (std::size_t i = 0; i < splats.size(); ++i) {
    const SplatRecord record = record_of(splats, i);
    std::memcpy(bytes->data() + i * sizeof record, &record, sizeof record);
  }
  if (!is_splat(*bytes))
    return fail(name, "splats",
                "most positions or scales are beyond 1e9; a .splat is known by smaller ones");
  return bytes;
}

}  // namespace fluxgs
