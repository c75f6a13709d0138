// Memory limit that fluxgs/io/spz.h promises.
#pragma once

#include "fluxgs/io/scene_file.h"
#include "harness.h"
#include "io/spz/spz_layout.h"

namespace fluxgs::fuzz {

/// 2^20 splats may be promised by any file; those beyond take 1/32 of their unpacked size in it,
/// and at most 72/16 of that (version 1, degree 0) when unpacked and in the cloud.
inline constexpr Allowance kSpzAllowance{
    (std::size_t(1) << 20) * (io::spz_splat_bytes(4, 3) + splat_memory_bytes(1, 3)) + (1 << 20),
    32 * 72 / 16};

}  // namespace fluxgs::fuzz
