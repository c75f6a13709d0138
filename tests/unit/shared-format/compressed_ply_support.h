// Compressed .ply files made by hand, from packed words or from a cloud.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "fluxgs/io/compressed_ply.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "support.h"

namespace fluxgs::test {

constexpr std::array<const char*, 18> kChunkProperties{
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
constexpr std::array<const char*, 4> kPackedProperties{"packed_position", "packed_rotation",
                                                       "packed_scale", "packed_color"};

struct PackedSplat {
  std::uint32_t position = 0, rotation = 0, scale = 0, colour = 0;
};

struct CompressedPly {
  bool colour_bounds = true;
  int sh_degree = 0;
  std::vector<std::array<float, 18>> chunks;
  std::vector<PackedSplat> splats;
  std::vector<std::uint8_t> sh;  ///< [splat][property]

  std::string header() const {
    std::string text =
        fmt::format("ply\nformat binary_little_endian 1.0\nelement chunk {}\n", chunks.size());
    for (std::size_t i = 0; i < (colour_bounds ? 18u : 12u); ++i) {
      text += fmt::format("property float {}\n", kChunkProperties[i]);
    }
    text += fmt::format("element vertex {}\n", splats.size());
    for (const char* packed : kPackedProperties) text += fmt::format("property uint {}\n", packed);
    if (sh_degree > 0) text += fmt::format("element sh {}\n", splats.size());
    for (int i = 0; i < 3 * sh_rest_count(sh_degree); ++i) {
      text += fmt::format("property uchar f_rest_{}\n", i);
    }
    return text + "end_header\n";
  }
  Bytes data() const {
    Bytes bytes;
    for (const auto& chunk : chunks) {
      for (std::size_t i = 0; i < (colour_bounds ? 18u : 12u); ++i) append(bytes, chunk[i]);
    }
    for (const PackedSplat& s : splats) {
      for (const std::uint32_t word : {s.position, s.rotation, s.scale, s.colour}) {
        append(bytes, word);
      }
    }
    for (const std::uint8_t level : sh) append(bytes, level);
    return bytes;
  }
  Bytes bytes() const {
    Bytes all = bytes_of(header());
    const Bytes rows = data();
    all.insert(all.end(), rows.begin(), rows.end());
    return all;
  }
};

inline double display_colour(float dc) { return 0.5 + math::kSh0 * double{dc}; }

/// A fraction of [low, high] in `bits` bits, rounded to nearest.
inline std::uint32_t pack_fraction(double value, double low, double high, int bits) {
  const double most = (1 << bits) - 1;
  const double t = high > low ? (value - low) / (high - low) : 0;
  return static_cast<std::uint32_t>(std::lround(std::clamp(t, 0.0, 1.0) * most));
}

inline std::uint32_t pack_rotation(const glm::quat& rotation) {
  glm::dquat q = glm::normalize(glm::dquat(rotation));
  std::array<double, 4> parts{q.w, q.x, q.y, q.z};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(parts[i]) > std::abs(parts[largest])) largest = i;
  }
  const double sign = parts[largest] < 0 ? -1 : 1;
  auto word = static_cast<std::uint32_t>(largest);
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    word = word << 10 | pack_fraction(sign * parts[i], -std::sqrt(0.5), std::sqrt(0.5), 10);
  }
  return word;
}

/// Quantize a cloud in its order, with bounds of the splats in each chunk.
inline CompressedPly compress(const SplatCloud& cloud) {
  CompressedPly file;
  file.sh_degree = cloud.sh_degree;
  for (std::size_t begin = 0; begin < cloud.size(); begin += 256) {
    const std::size_t end = std::min(cloud.size(), begin + 256);
    std::array<float, 18> bounds{};
    const auto values = [&](std::size_t i) {
      std::array<float, 9> v{};
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        v[k] = cloud.positions[i][c];
        v[3 + k] = cloud.log_scales[i][c];
        v[6 + k] = static_cast<float>(display_colour(cloud.sh_dc[i][c]));
      }
      return v;
    };
    for (std::size_t k = 0; k < 9; ++k) {
      float low = values(begin)[k], high = low;
      for (std::size_t i = begin; i < end; ++i) {
        low = std::min(low, values(i)[k]);
        high = std::max(high, values(i)[k]);
      }
      bounds[k / 3 * 6 + k % 3] = low;
      bounds[k / 3 * 6 + 3 + k % 3] = high;
    }
    file.chunks.push_back(bounds);
    for (std::size_t i = begin; i < end; ++i) {
      const auto v = values(i);
      const auto part = [&](std::size_t k, int bits) {
        return pack_fraction(v[k], bounds[k / 3 * 6 + k % 3], bounds[k / 3 * 6 + 3 + k % 3], bits);
      };
      const double opacity = 1 / (1 + std::exp(-double{cloud.opacity_logits[i]}));
      file.splats.push_back({part(0, 11) << 21 | part(1, 10) << 11 | part(2, 11),
                             pack_rotation(cloud.rotations[i]),
                             part(3, 11) << 21 | part(4, 10) << 11 | part(5, 11),
                             part(6, 8) << 24 | part(7, 8) << 16 | part(8, 8) << 8 |
                                 pack_fraction(opacity, 0, 1, 8)});
      const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
      for (int c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < rest; ++k) {
          const double level = std::floor((cloud.sh_rest[i * rest + k][c] / 8.0 + 0.5) * 256);
          file.sh.push_back(static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0)));
        }
      }
    }
  }
  return file;
}

inline Expected<SceneFile> read(const CompressedPly& file) {
  return read_compressed_ply(file.bytes(), "test.ply");
}

}  // namespace fluxgs::test
