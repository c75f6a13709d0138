// The .ply of 3DGS: text and binary of either byte order.
#include "fluxgs/io/ply.h"

#include "harness.h"

namespace fluxgs::fuzz {

// The least that a property takes is 16 bytes of header, "property char x\n", and 48 in memory, in
// a list that may have grown to twice its need.
FLUXGS_FUZZ_TARGET(ply) {
  return try_reader(input, {64 << 10, 16}, [](Input bytes) { return read_ply(bytes, "x"); });
}

}  // namespace fluxgs::fuzz
