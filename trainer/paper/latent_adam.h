// The optimiser's step on the latents (appearance_model.h).
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/core/adam.h"
#include "trainer/core/parallel.h"

namespace fluxgs {

/// Learning rates of the first three rows (E_mag, or the constant coefficient of c′) and of the
/// others (E_dir, or degree 1).
struct LatentRates {
  double constant, directional;
};

/// Adam for the splats marked in `visible` (padded to a multiple of 16), as adam_step() for the
/// parameters. The moments have the latents' shape.
void latent_adam_step(PlanarFloats& latents, AdamState& state, const PlanarFloats& gradient,
                      const std::vector<std::uint8_t>& visible, const LatentRates& rates,
                      const AdamStep& adam, const Threads& threads);

}  // namespace fluxgs
