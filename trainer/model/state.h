// Everything that changes while training: what a checkpoint holds.
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/base/random.h"
#include "trainer/model/adam.h"
#include "trainer/model/parameters.h"

namespace fluxgs {

/// Rows of TrainState::statistics, gathered over visible splats since the last densification.
namespace statistic {
inline constexpr int gradient_sum = 0;  // Σ |∂L/∂centre|, normalised device coordinates
inline constexpr int views = 1;         // how often the splat was seen
inline constexpr int radius = 2;        // largest extent on the screen, px
inline constexpr int count = 3;
}  // namespace statistic

struct TrainState {
  PlanarFloats parameters;
  AdamState adam;
  PlanarFloats statistics;
  int iteration = 0;  ///< steps done
  Random random;
  std::vector<std::uint32_t> view_order;  ///< a random permutation of the training photos
  std::uint32_t next_view = 0;            ///< position in it
};

}  // namespace fluxgs
