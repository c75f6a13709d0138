// What the paper keeps of the higher bands (its section "Monte Carlo Specular Energy Aggregator",
// the equation of E_mag and E_dir): mean and first moment of the positive part of a residual,
//
//   E_mag = ⟨max(0, f(d))⟩,  E_dir = ⟨d·max(0, f(d))⟩,  ⟨·⟩: mean over the sphere,
//
// where f is the colour of degree 3 less that of a lower degree.
//
// With max(0, f) = (f + |f|)/2, the paper's residual of band 3 alone has E_dir = 0: ⟨d·f⟩ vanishes
// because d is of band 1 and f of band 3, ⟨d·|f|⟩ because |f| is even where f is odd. What Monte
// Carlo returns is its own noise. Residual::from_1 keeps band 2, which is even, and has no such
// symmetry.
#pragma once

#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/quadrature.h"
#include "trainer/model/appearance_choices.h"
#include "trainer/paper/energy_kernels.h"

namespace fluxgs {

/// 12 rows in the column order of networks/appearance.h ("energy"): E_mag (r, g, b), E_dir along x
/// (r, g, b), along y, along z; units of colour. Bands that `parameters` do not have are zero.
/// Always finite: 0 where the coefficients are not, or are too large for their sums.
PlanarFloats energy_moments(const PlanarFloats& parameters, Residual residual,
                            const SphereRule& rule, const Threads& threads,
                            const EnergyKernels& kernels = energy_kernels(best_isa()));

}  // namespace fluxgs
