#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <span>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "fluxgs/io/compressed_ply.h"
#include "io/ply/compressed_ply_layout.h"
#include "io/ply/ply_filter.h"
#include "io/ply/ply_view.h"
#include "io/splat/smallest_three.h"
#include "io/splat/spatial_order.h"

namespace fluxgs {
namespace {

using namespace io;

// Other writers limit logarithms of scales to ±20, too: flat splats would coarsen their chunk's.
constexpr float kMostLogScale = 20;
constexpr float kMostColour = 1e30F;  // beyond, the reader's change of scale leaves the floats

glm::vec3 log_scale_at(const SplatCloud& cloud, std::size_t i) {
  return glm::clamp(cloud.log_scales[i], -kMostLogScale, kMostLogScale);
}

glm::vec3 colour_at(const SplatCloud& cloud, std::size_t i) {
  const glm::vec3& dc = cloud.sh_dc[i];
  return glm::clamp(glm::vec3(colour_of(dc.x), colour_of(dc.y), colour_of(dc.z)), -kMostColour,
                    kMostColour);
}

struct Bounds {
  glm::vec3 low{0}, high{0};
};

// Bounds of value(i) over the splats of a chunk.
template <class Value>
Bounds bounds_of_splats(std::span<const std::uint32_t> splats, const Value& value) {
  Bounds range{value(splats[0]), value(splats[0])};
  for (const std::uint32_t i : splats) {
    range.low = glm::min(range.low, value(i));
    range.high = glm::max(range.high, value(i));
  }
  return range;
}

// The nearest of the levels of so many bits, from low to high.
std::uint32_t level(double value, double low, double high, int bits) {
  const double most = (1u << bits) - 1;
  const double fraction = high > low ? (value - low) / (high - low) : 0;
  return static_cast<std::uint32_t>(std::lround(std::clamp(fraction, 0.0, 1.0) * most));
}

std::uint32_t pack_vector(const glm::vec3& v, const Bounds& range) {
  return level(v.x, range.low.x, range.high.x, 11) << 21 |
         level(v.y, range.low.y, range.high.y, 10) << 11 |
         level(v.z, range.low.z, range.high.z, 11);
}

std::uint32_t pack_rotation(const glm::quat& rotation) {
  const io::SmallestThree parts =
      io::to_smallest_three({rotation.w, rotation.x, rotation.y, rotation.z}, 0);
  auto word = static_cast<std::uint32_t>(parts.largest);
  constexpr double kMost = std::numbers::sqrt2 / 2;
  for (const double c : parts.others) word = word << 10 | level(c, -kMost, kMost, 10);
  return word;
}

std::uint32_t pack_colour(const glm::vec3& colour, const Bounds& range, float opacity) {
  std::uint32_t word = 0;
  for (int c = 0; c < 3; ++c) word = word << 8 | level(colour[c], range.low[c], range.high[c], 8);
  return word << 8 | byte_of(opacity);
}

std::uint8_t pack_sh(float value) {
  return static_cast<std::uint8_t>(std::clamp(std::floor((value / 8.0 + 0.5) * 256), 0.0, 255.0));
}

template <class T>
void put(std::byte*& out, const T& value) {
  std::memcpy(out, &value, sizeof value);
  out += sizeof value;
}

void put_bounds(std::byte*& out, const Bounds& range) {
  for (const glm::vec3& v : {range.low, range.high})
    for (int c = 0; c < 3; ++c) put(out, v[c]);
}

void put_chunk(const SplatCloud& cloud, std::span<const std::uint32_t> splats, std::byte*& chunks,
               std::byte*& words) {
  const auto position = [&](std::uint32_t i) { return cloud.positions[i]; };
  const auto scale = [&](std::uint32_t i) { return log_scale_at(cloud, i); };
  const auto colour = [&](std::uint32_t i) { return colour_at(cloud, i); };
  const Bounds positions = bounds_of_splats(splats, position),
               scales = bounds_of_splats(splats, scale), colours = bounds_of_splats(splats, colour);
  for (const Bounds& range : {positions, scales, colours}) put_bounds(chunks, range);
  for (const std::uint32_t i : splats) {
    put(words, pack_vector(position(i), positions));
    put(words, pack_rotation(cloud.rotations[i]));
    put(words, pack_vector(scale(i), scales));
    put(words, pack_colour(colour(i), colours, opacity_of(cloud.opacity_logits[i])));
  }
}

void put_sh(const SplatCloud& cloud, std::uint32_t splat, std::byte*& out) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (int c = 0; c < 3; ++c)  // channel-major
    for (std::size_t k = 0; k < rest; ++k) put(out, pack_sh(cloud.sh_rest[splat * rest + k][c]));
}

std::string header_of(const SplatCloud& cloud, const std::optional<InitialView>& start,
                      std::size_t chunks) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\n{}{}element chunk {}\n",
                                 comment_lines(cloud.filter), comment_line(start), chunks);
  for (const std::string_view name : kChunkNames) text += fmt::format("property float {}\n", name);
  text += fmt::format("element vertex {}\n", cloud.size());
  for (const std::string_view name : kPackedNames) text += fmt::format("property uint {}\n", name);
  const int rest = 3 * sh_rest_count(cloud.sh_degree);
  if (rest > 0) text += fmt::format("element sh {}\n", cloud.size());
  for (int i = 0; i < rest; ++i) text += fmt::format("property uchar f_rest_{}\n", i);
  return text + "end_header\n";
}

}  // namespace

Expected<std::vector<std::byte>> encode_compressed_ply(const SplatCloud& cloud,
                                                       const std::string& name,
                                                       const std::optional<InitialView>& start) {
  SplatCloud storage;
  const auto finite = writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  const SplatCloud& splats = **finite;
  const std::size_t count = splats.size(), chunks = (count + kChunkSplats - 1) / kChunkSplats;
  const std::string header = header_of(splats, start, chunks);
  const std::size_t chunk_bytes = kChunkNames.size() * sizeof(float),
                    word_bytes = kPackedNames.size() * sizeof(std::uint32_t),
                    sh_bytes = 3 * static_cast<std::size_t>(sh_rest_count(splats.sh_degree));
  auto bytes =
      allocate_bytes(header.size() + chunks * chunk_bytes + count * (word_bytes + sh_bytes), name);
  if (!bytes) return bytes;
  const auto order = spatial_order(splats.positions);
  std::memcpy(bytes->data(), header.data(), header.size());
  std::byte* to_chunks = bytes->data() + header.size();
  std::byte* to_words = to_chunks + chunks * chunk_bytes;
  std::byte* to_sh = to_words + count * word_bytes;
  for (std::size_t begin = 0; begin < count; begin += kChunkSplats)
    put_chunk(splats, std::span(order).subspan(begin, std::min(kChunkSplats, count - begin)),
              to_chunks, to_words);
  for (const std::uint32_t i : order) put_sh(splats, i, to_sh);
  return bytes;
}

}  // namespace fluxgs
