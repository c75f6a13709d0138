// Cells as files of version 2 have them: by Draco's sequential point-cloud encoder.
#pragma once

#include <span>

#include "codec/octree.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/error.h"

namespace fluxgs::codec {

/// Reads cells.size() cells. What Draco is about to read is checked first: its number of points
/// must be that, of one attribute of three 32-bit integers, because its own decoder allocates what
/// its header says. Errors (without a file's name): cut, damaged, another count.
Expected<void> decode_draco(ByteReader& in, std::span<Cell> cells);

}  // namespace fluxgs::codec
