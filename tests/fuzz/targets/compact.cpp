// A whole scene of the compact codec: two bytes of count, one of its kind, then the stream. The
// kind is the degree, plus 128 with the networks' energy instead of colours, plus 64 for version 2.
#include "codec/compact.h"

#include <algorithm>

#include "harness.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(compact) {
  Parameters parameters(input);
  const std::size_t asked = parameters.word();
  const int kind = parameters.byte();
  const int degree = kind % 4;
  const bool has_energy = kind >= 128;
  const auto cells = kind % 128 >= 64 ? codec::CellCoding::draco : codec::CellCoding::octree;
  const std::size_t count = std::min(asked, codec::max_splats(parameters.rest().size()));
  if (const auto sizes = codec::attribute_bytes(parameters.rest(), degree, has_energy); !sizes) {
    check_error(sizes.error());
  }
  const Meter meter;
  std::vector<float> energy;
  const auto cloud = codec::decode_compact(parameters.rest(), count, degree,
                                           has_energy ? &energy : nullptr, cells);
  // compact.h: the cloud and 64 bytes a splat, or 24 and 12 for each coefficient; a table of
  // Draco's.
  const std::size_t each = std::max<std::size_t>(
      has_energy ? 128 : 64, 12 * static_cast<std::size_t>(sh_rest_count(degree)) + 24);
  check_memory(meter.peak(), {(6 << 20) + each * count + splat_memory_bytes(count, degree), 64},
               input.size(), 0);
  if (!cloud) {
    check_error(cloud.error());
    return Worth::keep;
  }
  require(cloud->size() == count && cloud->sh_degree == degree, "the scene is as large as asked");
  check_cloud(*cloud);
  require(energy.size() == (has_energy ? count * codec::kEnergyChannels : 0),
          "the energy is as large as asked");
  return worth_of(count);
}

}  // namespace fluxgs::fuzz
