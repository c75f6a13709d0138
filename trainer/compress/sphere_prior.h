// Weight of the whole sphere in fits of SH coefficients to views (sh_fit.h): the weight that
// predicts views best that were left out of the fit.
//
// Many images all around need no prior, and a prior makes their fit worse. With few images, colours
// between them are arbitrary without one.
#pragma once

#include "trainer/compress/fit_splats.h"

namespace fluxgs {

/// Candidates. Of trained captures chesscat takes the second, banana (12 images) the third, fox,
/// snowmiku and a rendered glossy one the first. At the SH reduction of banana, 0.14 and 0.29 dB of
/// test PSNR that the first would lose are gained or kept. Larger ones would lose even less there,
/// but splats that are fitted less well keep more SH coefficients instead: with 0.1 its file is 4%
/// larger in the end, and no better.
inline constexpr double kSpherePriors[] = {kSpherePrior, 0.01, 0.03};

/// Σ w_v·|c(d_v) − a(d_v)|² over views, colour channels, degrees 0 to 2 and splats (4096 of them at
/// most, evenly spread), where a is c fitted to all views of the splat but v.
double left_out_loss(const PlanarFloats& parameters, const ViewWeights& views, double prior,
                     const Threads& threads);

/// The candidate with the least left_out_loss(), of equals the smaller.
double best_sphere_prior(const PlanarFloats& parameters, const ViewWeights& views,
                         const Threads& threads);

}  // namespace fluxgs
