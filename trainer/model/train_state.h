// Everything that changes while training: the content of a checkpoint.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "trainer/core/adam.h"
#include "trainer/core/parameters.h"
#include "trainer/core/random.h"

namespace fluxgs {

/// Rows of TrainState::statistics, gathered over visible splats since the last densification.
namespace statistic {
inline constexpr int gradient_sum = 0;  // Σ |∂L/∂centre|, normalised device coordinates
inline constexpr int views = 1;         // number of times the splat was visible
inline constexpr int radius = 2;        // largest extent on the screen, px
inline constexpr int count = 3;
}  // namespace statistic

/// Further values for each splat, which a phase owns.
struct SplatValues {
  PlanarFloats values;
  bool moments = false;  ///< moments of an optimiser: zero for new splats
};

struct TrainState {
  PlanarFloats parameters;
  AdamState adam;
  PlanarFloats statistics;
  /// Each splat's SH degree (its higher bands are zero and stay so), at most that of the
  /// parameters' rows; empty: all have that.
  std::vector<std::uint8_t> degrees;
  std::map<std::string, SplatValues> attached;              ///< by names that phases choose
  std::map<std::string, std::vector<double>> phase_values;  ///< Phase::save() by name
  int iteration = 0;                                        ///< iterations done
  double max_pairs = 0;  ///< largest number of splat–tile pairs for each visible splat so far
  /// PSNR that training images lost when an event last removed splats, dB, over the logarithm of
  /// the splats before to those after it; 0: none has yet.
  double splat_worth = 0;
  Random random;
  std::vector<std::uint32_t> view_order;  ///< a random permutation of the training views
  std::uint32_t next_view = 0;            ///< position in it
};

/// Makes splat i of the result a copy of splat order[i], with the moments of splat moments[i], or
/// zeros for PlanarFloats::kNew; the statistics start anew.
void rearrange(TrainState& state, const std::vector<std::uint32_t>& order,
               const std::vector<std::uint32_t>& moments);

/// Sets the moments of splat i to zero.
void clear_moments(TrainState& state, std::size_t i);

}  // namespace fluxgs
