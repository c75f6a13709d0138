// Positions of the compact codec, an octree.
#include "position_stream.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(positions) { return read_positions(input, codec::CellCoding::octree, 1 << 20); }

}  // namespace fluxgs::fuzz
