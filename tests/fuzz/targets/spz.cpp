// SPZ as it lies in a file. What is inside its compression, spz_payload.cpp reaches better.
#include "fluxgs/io/spz.h"

#include "harness.h"
#include "spz_allowance.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(spz) {
  return try_reader(input, kSpzAllowance, [](Input bytes) {
    const bool recognised = is_spz(bytes);
    auto scene = read_spz(bytes, "x");
    require(recognised || !scene, "a file that can be read is recognised");
    return scene;
  });
}

}  // namespace fluxgs::fuzz
