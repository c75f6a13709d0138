// Everything that changes while training: what a checkpoint holds.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fluxgs/io/compact_glb.h"
#include "trainer/core/adam.h"
#include "trainer/core/parameters.h"
#include "trainer/core/random.h"
#include "trainer/paper/appearance_model.h"

namespace fluxgs {

/// Rows of TrainState::statistics, gathered over visible splats since the last densification.
namespace statistic {
inline constexpr int gradient_sum = 0;  // Σ |∂L/∂centre|, normalised device coordinates
inline constexpr int views = 1;         // how often the splat was seen
inline constexpr int radius = 2;        // largest extent on the screen, px
inline constexpr int count = 3;
}  // namespace statistic

/// Colours that networks make, after the switch: what is trained in the place of the parameters'
/// rows sh_dc and sh_rest, which hold the networks' results for the splats last seen.
struct NetworkState {
  AppearanceModel model;
  PlanarFloats latents;
  AdamState adam;
};

/// While parameters are what a compact file would hold (trainer/compress/rounding.h).
struct RoundingState {
  CompactSteps steps;
  ErrorCosts costs;      ///< all of them
  PlanarFloats offsets;  ///< rounded − exact; empty: not rounded yet
};

struct TrainState {
  PlanarFloats parameters;
  AdamState adam;
  PlanarFloats statistics;
  /// Each splat's SH degree (its higher bands are zero and stay so), at most
  /// that of the parameters' rows; empty: all have that.
  std::vector<std::uint8_t> degrees;
  std::optional<NetworkState> networks;
  std::optional<RoundingState> rounding;
  int switched_at = 0;   ///< the iteration after which the SH coefficients were reduced; 0: not yet
  int iteration = 0;     ///< steps done
  double max_pairs = 0;  ///< most splat–tile pairs for each visible splat, of all steps
  Random random;
  std::vector<std::uint32_t> view_order;  ///< a random permutation of the training images
  std::uint32_t next_view = 0;            ///< position in it
};

/// Makes splat i of the result a copy of splat order[i], with the moments of splat moments[i], or
/// zeros for PlanarFloats::kNew; the statistics start anew.
void rearrange(TrainState& state, const std::vector<std::uint32_t>& order,
               const std::vector<std::uint32_t>& moments);

/// Forgets the moments of splat i.
void clear_moments(TrainState& state, std::size_t i);

}  // namespace fluxgs
