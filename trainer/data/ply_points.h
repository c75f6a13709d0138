// Sparse points in a .ply, as nerfstudio writes them.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Add the vertices of a .ply (ascii or binary little-endian) to the source's points: x y z, and
/// red green blue of 8 bits where present (white otherwise). Vertices must be the first element,
/// without lists. Points that are not finite are dropped with a warning. Errors: any other header,
/// a header that promises more than the file holds.
Expected<void> read_ply_points(const std::filesystem::path& file, Source& source);

}  // namespace fluxgs
