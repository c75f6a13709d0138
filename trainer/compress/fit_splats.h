// Fits of lower SH degrees to SH of degree 3, for all splats at once.
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/compress/view_weights.h"
#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/quadrature.h"

namespace fluxgs {

/// Least weight of the whole sphere beside the views (sh_fit.h). On two trained captures
/// (fox: 43 images; snowmiku: 84) the loss over images that were not fitted to is least between
/// 3e-4 and 3e-3, for degree 1 and 2 alike; at 1e-6 it is up to 35% larger (fox, degree 2).
inline constexpr double kSpherePrior = 1e-3;

/// The first rows of parameters, or of gradients or moments laid out like them, up to a degree that
/// they have: ShReduction::truncate.
PlanarFloats rows_of_degree(const PlanarFloats& rows, int degree);

/// Colours of lower degrees from least squares over the views (ShReduction::view_ls): rows as
/// `parameters`, zeros beyond degrees[i], which is not above their own degree. Rows before sh_dc
/// stay as they are. A splat that no view sees is truncated. One with a coefficient that is not
/// finite gets a constant colour of NaN: it was not drawn before and is not drawn now.
PlanarFloats fit_to_views(const PlanarFloats& parameters, const std::vector<std::uint8_t>& degrees,
                          const ViewWeights& views, double prior, const Threads& threads);

/// The same with one degree for all splats, and rows up to that degree only.
PlanarFloats fit_to_views(const PlanarFloats& parameters, int degree, const ViewWeights& views,
                          double prior, const Threads& threads);

/// The same with the directions of a rule in the place of views (ShReduction::uniform_ls):
/// truncation where the rule is exact for polynomials of degree 3 + `degree`.
PlanarFloats fit_to_sphere(const PlanarFloats& parameters, int degree, const SphereRule& rule,
                           const Threads& threads);

/// The part of each splat's colour that lower degrees cannot show in the views.
struct Unexplained {
  std::vector<float> weights = {};  ///< Σ w_v: pixels
  /// Row d, 0…3 (row 3: zeros): Σ (w_v/W)·|c(d_v) − a(d_v)|², the three channels added up, for a
  /// truncated to degree d, and fitted. 0 where no view sees the splat or colours are not finite.
  PlanarFloats truncated = {}, fitted = {};
};

Unexplained unexplained_variance(const PlanarFloats& parameters, const ViewWeights& views,
                                 double prior, const Threads& threads);

}  // namespace fluxgs
