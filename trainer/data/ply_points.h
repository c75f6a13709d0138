// Sparse points of a data set in a .ply, as nerfstudio writes them.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Adds the vertices of a .ply (fluxgs/io/ply_points.h) to the source's points. Points that are not
/// finite are dropped with a warning. Errors: as of fluxgs::read_ply_points().
Expected<void> add_ply_points(const std::filesystem::path& file, Source& source);

}  // namespace fluxgs
