// Layout of SPZ, the same for its reader and its writer (README of nianticlabs/spz).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

inline constexpr char kSpzMagic[] = {'N', 'G', 'S', 'P'};
inline constexpr std::size_t kSpzHeader = 16;       ///< versions 1 to 3, inside the gzip
inline constexpr std::size_t kSpzHeader4 = 32;      ///< version 4, outside the zstd streams
inline constexpr std::size_t kSpzStreamEntry = 16;  ///< version 4, table of contents
inline constexpr unsigned kSpzAntialiased = 1, kSpzExtensions = 2;  ///< flags

/// Record that names the axes: its type, and the codes of right-up-back and right-down-front.
inline constexpr std::uint32_t kSpzAxesRecord = 0xADBE0003;  ///< SPZ_ADOBE_coordinate_system
inline constexpr std::uint32_t kSpzCodeRub = 4, kSpzCodeRdf = 6;

inline constexpr int kSpzMaxDegree = 4;  ///< of which a SplatCloud holds 3

/// Colour scale of degree 0: smaller than the basis function, so that colours a little outside of
/// 0…1 can be told.
inline constexpr double kSpzColour = 0.15;
inline constexpr double kSpzLeastLogScale = -10, kSpzLogScaleSteps = 16;
inline constexpr unsigned kSpzRotationMost = 511;  ///< 9 bits and a sign stand for 0…1/√2

/// The attributes in the order in which they are stored, each for all splats.
enum SpzAttribute : std::size_t {
  kSpzPositions,
  kSpzAlphas,
  kSpzColours,
  kSpzScales,
  kSpzRotations,
  kSpzSh,
  kSpzAttributes
};

/// Bytes of each attribute of one splat.
constexpr std::array<std::size_t, kSpzAttributes> spz_attribute_bytes(unsigned version,
                                                                      int sh_degree) {
  return {version == 1 ? 6u : 9u,
          1,
          3,
          3,
          version >= 3 ? 4u : 3u,
          3 * static_cast<std::size_t>(sh_rest_count(sh_degree))};
}

/// Bytes of one splat.
constexpr std::size_t spz_splat_bytes(unsigned version, int sh_degree) {
  std::size_t sum = 0;
  for (const std::size_t bytes : spz_attribute_bytes(version, sh_degree)) sum += bytes;
  return sum;
}

/// Signs between right-up-back, the axes of the specification, and right-down-front, those of a
/// SplatCloud.
inline constexpr glm::vec3 kRightUpBack{1, -1, -1};

/// Effect of flipping axes on a splat: mirrored twice, a rotation stays one.
struct AxisFlip {
  glm::vec3 position;        ///< ±1 for each axis
  glm::vec3 rotation;        ///< for x, y, z of the quaternion; w stays
  std::array<float, 15> sh;  ///< parity of the basis functions from degree 1
};

inline AxisFlip make_axis_flip(const glm::vec3& s) {
  const float x = s.x, y = s.y, z = s.z;
  return {
      s, {y * z, x * z, x * y}, {y, z, x, x * y, y * z, 1, x * z, 1, y, x * y * z, y, z, x, z, x}};
}

}  // namespace fluxgs::io
