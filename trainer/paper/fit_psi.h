// Pre-training of Ψ on known colours. The paper does not say with which weights training continues
// after the SH reduction; random ones would throw away the colours learned so far.
#pragma once

#include "trainer/core/isa.h"
#include "trainer/core/parallel.h"
#include "trainer/paper/appearance_model.h"

namespace fluxgs {

struct PsiFitOptions {
  int steps = 500;
  std::size_t batch = 8192;  ///< splats of an iteration, drawn anew for each
  double rate = 0.01;        ///< of Adam; falls to 0 along a quarter of a cosine
  /// The same for E; 0 keeps it as it is. E knows nothing of the constant coefficient, which Ψ can
  /// then only guess from the position: on two scans of 91 k and 153 k splats, whose coefficients
  /// deviate by 0.58 and 0.54, an error of 0.47 and 0.53 is left after 500 iterations. With E moved
  /// too it is 0.017 and 0.033, after 2,000 iterations 0.0007 and 0.0026.
  double latent_rate = 0.02;
  AdamConstants adam = {0.9, 0.999, 1e-15};
  std::uint64_t seed = 1;
};

/// Root of the mean squared error over all coefficients of all splats.
struct PsiFitReport {
  double rms_before = 0, rms_after = 0;
};

/// Minimises |Ψ(E, f(μ̂)) − c′|² over Ψ's weights and E. `target` holds c′ in
/// networks::kShColumns rows, in the frame of the parameters; splats whose c′, E or position is not
/// finite are left out. Adam's state of Ψ begins anew afterwards. Without Ψ nothing happens.
PsiFitReport fit_psi(AppearanceModel& model, const PlanarFloats& parameters, PlanarFloats& latents,
                     const PlanarFloats& target, const PsiFitOptions& options,
                     const Threads& threads, Isa isa = best_isa());

}  // namespace fluxgs
