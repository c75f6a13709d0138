// Energy moments of the higher SH bands (paper, "Monte Carlo Specular Energy Aggregator", the
// equation of E_mag and E_dir): mean and first moment of the positive part of a residual,
//
//   E_mag = ⟨max(0, f(d))⟩,  E_dir = ⟨d·max(0, f(d))⟩,  ⟨·⟩: mean over the sphere,
//
// where f is the colour of degree 3 less that of a lower degree.
//
// With max(0, f) = (f + |f|)/2, the paper's residual of band 3 alone has E_dir = 0: ⟨d·f⟩ vanishes
// because d is of band 1 and f of band 3, ⟨d·|f|⟩ because |f| is even where f is odd. Monte
// Carlo returns its own noise. Residual::from_1 keeps band 2, which is even, and has no such
// symmetry.
#pragma once

#include <array>
#include <string_view>

#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/quadrature.h"
#include "trainer/paper/energy_kernels.h"

namespace fluxgs {

/// The part of the colour that the moments are taken of: degree 3 less a lower degree.
enum class Residual {
  from_1,  ///< bands 2 and 3
  from_2,  ///< band 3 alone, as the paper has it: its E_dir is zero
  from_0   ///< bands 1, 2 and 3
};
inline constexpr std::array<std::string_view, 3> kResidualNames = {"3-1", "3-2", "3-0"};

/// 12 rows in the column order of networks/appearance.h ("energy"): E_mag (r, g, b), E_dir along x
/// (r, g, b), along y, along z; units of colour. Bands that `parameters` do not have are zero.
/// Always finite: 0 where the coefficients are not, or are too large for their sums.
PlanarFloats energy_moments(const PlanarFloats& parameters, Residual residual,
                            const SphereRule& rule, const Threads& threads,
                            const EnergyKernels& kernels = energy_kernels(best_isa()));

/// Adds the projection of max(0, residual) onto degree 0 and 1: with Y₀ and Y₁ the basis functions'
/// constants, 4π·Y₀·E_mag and 4π·Y₁·E_dir (order −y, z, −x). "Monte Carlo directional moments
/// largely match 1st-order SH" (paper, Insight 1), taken literally.
void add_projection(const PlanarFloats& energy, PlanarFloats& parameters);

}  // namespace fluxgs
