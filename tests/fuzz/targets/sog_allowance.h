// Memory limit that fluxgs/io/sog.h and src/io/sog/sog_decode.h promise.
#pragma once

#include "fluxgs/io/scene_file.h"
#include "harness.h"

namespace fluxgs::fuzz {

/// 65,536 splats for any file and 16 for each byte, each in the cloud and as 4 pixels of two
/// images, once as bytes and once inside of libwebp; 2^20 pixels of each for any file, and a
/// palette.
inline constexpr Allowance kSogAllowance{
    65536 * (splat_memory_bytes(1, 3) + 64) + (std::size_t(1) << 20) * (2 * 8 + 2 * 12) + (4 << 20),
    16 * (splat_memory_bytes(1, 3) + 64) + 64};

}  // namespace fluxgs::fuzz
