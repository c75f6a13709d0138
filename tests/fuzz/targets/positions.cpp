// Positions of the compact codec, which Draco decodes: two bytes of count, then the stream.
#include "codec/positions.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/byte_reader.h"
#include "harness.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(positions) {
  Parameters parameters(input);
  std::vector<glm::vec3> positions(parameters.word());
  ByteReader in(parameters.rest());
  const Meter meter;
  const auto decoded = codec::decode_positions(in, positions);
  // Draco holds the numbers and their predictions, and a table of up to 2^20 entries.
  check_memory(meter.peak(), {6 << 20, 64}, input.size(), 32 * positions.size());
  if (!decoded) {
    check_error(decoded.error());
    return Worth::keep;
  }
  require(std::ranges::all_of(positions,
                              [](const glm::vec3& p) {
                                return std::isfinite(p.x) && std::isfinite(p.y) &&
                                       std::isfinite(p.z);
                              }),
          "positions are finite");
  return worth_of(positions.size());
}

}  // namespace fluxgs::fuzz
