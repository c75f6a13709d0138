// The compressed .ply of SuperSplat.
#include "fluxgs/io/compressed_ply.h"

#include "harness.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(compressed_ply) {
  return try_reader(input, {64 << 10, 16}, [](Input bytes) {
    is_compressed_ply(bytes);
    return read_compressed_ply(bytes, "x");
  });
}

}  // namespace fluxgs::fuzz
