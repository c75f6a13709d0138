// Opacity reset: now and then all opacities are lowered, so that splats that images need become
// opaque again and the others are pruned (Kerbl et al. 2023, section 5.2).
#pragma once

#include <memory>

#include "trainer/model/phase.h"

namespace fluxgs {

struct OpacityResetOptions {
  static constexpr const char* kTitle = "Opacity reset";
  int interval = 3000;  ///< iterations, before the last densification; 0: never
  double to = 0.01;     ///< 0…1, at most

  OptionFields fields(const TrainOptions& all);
};

/// True if opacities are reset at all; of resolved options.
bool resets_opacity(const TrainOptions& options);

/// Limits every opacity to `to` and clears the optimiser's memory of it.
void reset_opacity(TrainState& state, double to);

/// Null where opacities are never reset. After make_densification().
std::unique_ptr<Phase> make_opacity_reset(TrainOptions& options);

}  // namespace fluxgs
