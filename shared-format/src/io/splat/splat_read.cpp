#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "cloud/activation.h"
#include "fluxgs/io/splat.h"
#include "io/splat/splat_record.h"
#include "io/whole_cloud.h"

namespace fluxgs {
namespace {

using namespace io;

SplatRecord record_at(std::span<const std::byte> bytes, std::size_t i) {
  SplatRecord record;
  std::memcpy(&record, bytes.data() + i * sizeof record, sizeof record);
  return record;
}

glm::quat rotation_of(const SplatRecord& record) {
  const auto component = [&](std::size_t i) {
    return static_cast<float>(record.rotation[i] / kSplatRotationOne - 1);
  };
  return glm::quat(component(0), component(1), component(2), component(3));
}

bool is_plausible(const SplatRecord& record) {
  // Far beyond any scene, yet below what letters make when taken for a float (10¹⁰ and more).
  constexpr float kMax = 1e9f;
  const bool near = std::ranges::all_of(record.position, [](float p) {
    return std::abs(p) <= kMax;  // false for NaN
  });
  const bool sized = std::ranges::all_of(record.scale, [](float s) { return s >= 0 && s <= kMax; });
  // Digits and spaces make lengths of 1.1 and more, zeros 2.
  const double length = glm::length(rotation_of(record));
  return near && sized && std::abs(length - 1) <= kSplatLengthTolerance;
}

void store(const SplatRecord& record, const std::array<float, 256>& logits, std::size_t i,
           SplatCloud& cloud) {
  cloud.positions[i] = {record.position[0], record.position[1], record.position[2]};
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    cloud.log_scales[i][c] = static_cast<float>(log_scale(record.scale[k]));
    cloud.sh_dc[i][c] = dc_of(record.colour[k] / 255.0);
  }
  cloud.opacity_logits[i] = logits[record.colour[3]];
  const glm::quat q = rotation_of(record);
  cloud.rotations[i] = glm::dot(q, q) > 0 ? q : glm::quat(1, 0, 0, 0);
}

}  // namespace

bool is_splat(std::span<const std::byte> bytes) {
  constexpr std::size_t kSample = 256, kLeastWithTail = 4;
  const std::size_t count = bytes.size() / sizeof(SplatRecord);
  const bool tail = bytes.size() % sizeof(SplatRecord) != 0;
  if (count < (tail ? kLeastWithTail : 1)) return false;
  const std::size_t sample = std::min(count, kSample), step = count / sample;
  std::size_t plausible = 0;
  for (std::size_t i = 0; i < sample; ++i) plausible += is_plausible(record_at(bytes, i * step));
  return tail ? 10 * plausible >= 9 * sample : 2 * plausible >= sample;
}

Expected<SceneFile> read_splat(const ByteSource& source, const std::string& name, SplatSink& sink) {
  const std::uint64_t size = source.size(), tail = size % sizeof(SplatRecord);
  if (size < sizeof(SplatRecord)) {
    return fail(name, "size",
                fmt::format("is {} bytes; expected at least the {} bytes of a splat", size,
                            sizeof(SplatRecord)));
  }
  const ComingSplats coming{static_cast<std::size_t>(size / sizeof(SplatRecord))};
  if (const auto begun = sink.begin(coming); !begun) return std::unexpected(begun.error());
  const auto logits = logits_of_bytes();
  std::vector<std::byte> room;
  SceneFile scene;
  const auto fill = [&](std::size_t first, SplatCloud& part) -> Expected<void> {
    const auto records =
        source.read(first * sizeof(SplatRecord), part.size() * sizeof(SplatRecord), room);
    if (!records) return std::unexpected(records.error());
    for (std::size_t k = 0; k < part.size(); ++k) store(record_at(*records, k), logits, k, part);
    return {};
  };
  if (auto done = hand_on(coming, 0, name, sink, scene, fill); !done)
    return std::unexpected(done.error());
  if (tail != 0)
    scene.warnings.push_back(
        fmt::format("its size is no multiple of the {} bytes of a splat: it was cut off, or has a "
                    "tail; the {} whole splats are read, the last {} bytes ignored",
                    sizeof(SplatRecord), coming.count, tail));
  scene.format = "splat";
  scene.attribute_bits = {
      {"position", 96}, {"scale", 96}, {"rotation", 32}, {"opacity", 8}, {"sh_dc", 24}};
  scene.bytes = static_cast<std::size_t>(size);
  return scene;
}

Expected<SceneFile> read_splat(std::span<const std::byte> bytes, const std::string& name) {
  return read_whole(name,
                    [&](SplatSink& sink) { return read_splat(MemoryBytes(bytes), name, sink); });
}

}  // namespace fluxgs
