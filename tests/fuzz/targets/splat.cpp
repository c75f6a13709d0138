// The records of .splat.
#include "fluxgs/io/splat.h"

#include "harness.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(splat) {
  return try_reader(input, {64 << 10, 2}, [](Input bytes) {
    is_splat(bytes);
    return read_splat(bytes, "x");
  });
}

}  // namespace fluxgs::fuzz
