// One splat of a .splat file, see fluxgs/io/splat.h.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace fluxgs::io {

struct SplatRecord {
  std::array<float, 3> position;
  std::array<float, 3> scale;
  std::array<std::uint8_t, 4> colour;    ///< red, green, blue, opacity
  std::array<std::uint8_t, 4> rotation;  ///< w, x, y, z
};
static_assert(sizeof(SplatRecord) == 32);
static_assert(std::endian::native == std::endian::little, "records are copied as they are");

/// Levels per unit of a quaternion's component. 1 would be level 256: 255 stands for it.
inline constexpr double kSplatRotationOne = 128;

/// Error of a quaternion's length by rounding: four components rounded down, as some
/// writers do, shorten it by 4 · ½ · 1/128.
inline constexpr double kSplatLengthTolerance = 0.025;

}  // namespace fluxgs::io
