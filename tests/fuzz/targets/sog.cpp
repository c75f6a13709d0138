// A bundled .sog as it lies in a file. What is inside its images, sog_folder.cpp reaches better.
#include "fluxgs/io/sog.h"

#include "harness.h"
#include "sog_allowance.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(sog) {
  return try_reader(input, kSogAllowance, [](Input bytes) {
    is_sog(bytes);
    return read_sog(bytes, "x");
  });
}

}  // namespace fluxgs::fuzz
