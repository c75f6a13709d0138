// Memory limit that fluxgs/io/gltf.h promises.
#pragma once

#include "spz_allowance.h"

namespace fluxgs::fuzz {

/// That of SPZ, which may be inside; for each byte of JSON what a parser makes of "0,", as read and
/// as reduced; and 65,536 nodes, meshes, primitives, accessors and views of tinygltf.
inline constexpr Allowance kGlbAllowance{kSpzAllowance.fixed + (std::size_t(256) << 20),
                                         kSpzAllowance.per_byte + 64};

}  // namespace fluxgs::fuzz
