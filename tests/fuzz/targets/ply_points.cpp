// Point clouds in .ply: text and binary of either byte order.
#include "fluxgs/io/ply_points.h"

#include "harness.h"

namespace fluxgs::fuzz {

// A vertex takes 27 bytes in memory and at least 3 in the file; header as for the target ply.
FLUXGS_FUZZ_TARGET(ply_points) {
  const Meter meter;
  const auto points = read_ply_points(input, "x");
  check_memory(meter.peak(), {64 << 10, 16}, input.size(), 0);
  if (!points) {
    check_error(points.error());
    return Worth::keep;
  }
  require(points->positions.size() == points->colors.size(), "a colour for each position");
  return worth_of(points->positions.size());
}

}  // namespace fluxgs::fuzz
