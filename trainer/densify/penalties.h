// Penalties on opacity and size, so that splats that renders can do without vanish (Kheradmand et
// al. 2024, section 3.5).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "trainer/model/phase.h"

namespace fluxgs {

struct PenaltyOptions {
  static constexpr const char* kTitle = "Penalties";
  double opacity_weight = 0;  ///< of the mean opacity in the loss
  double scale_weight = 0;    ///< of the mean standard deviation in the loss

  OptionFields fields(const TrainOptions& all);
};

/// Adds the derivatives of opacity_weight × mean opacity + scale_weight × mean standard deviation
/// to the gradients of visible splats.
void add_penalties(const PlanarFloats& parameters, const std::vector<std::uint8_t>& visible,
                   const PenaltyOptions& options, PlanarFloats& gradient, const Threads& threads);

/// Null where both weights are 0.
std::unique_ptr<Phase> make_penalties(TrainOptions& options);

}  // namespace fluxgs
