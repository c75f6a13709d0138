// Positions of the compact codec in either coding: two bytes of count, then the stream.
#pragma once

#include <vector>

#include "codec/positions.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/math/finite.h"
#include "harness.h"

namespace fluxgs::fuzz {

/// `fixed`: bytes of tables that the decoder may take.
inline Worth read_positions(Input input, codec::CellCoding coding, std::size_t fixed) {
  Parameters parameters(input);
  const std::size_t count = parameters.word();
  if (count == 0) return Worth::forget;
  std::vector<glm::vec3> positions(count);
  ByteReader in(parameters.rest());
  const Meter meter;
  const auto decoded = codec::decode_positions(in, coding, positions);
  check_memory(meter.peak(), {fixed, 64}, input.size(), 44 * positions.size());
  if (!decoded) {
    check_error(decoded.error());
    return Worth::keep;
  }
  require(math::all_finite({&positions[0].x, 3 * positions.size()}), "positions are finite");
  return worth_of(positions.size());
}

}  // namespace fluxgs::fuzz
