// A .glb as it lies in a file.
#include "fluxgs/io/gltf.h"

#include "glb_allowance.h"
#include "harness.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(glb) {
  return try_reader(input, kGlbAllowance, [](Input bytes) { return read_glb(bytes, "x"); });
}

}  // namespace fluxgs::fuzz
