// Positions of the compact codec's version 2, which Draco decodes.
#include "position_stream.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(draco_positions) {
  // Draco holds the numbers and their predictions, and a table of up to 2^20 entries.
  return read_positions(input, codec::CellCoding::draco, 6 << 20);
}

}  // namespace fluxgs::fuzz
