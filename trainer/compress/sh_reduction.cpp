#include "trainer/compress/sh_reduction.h"

#include <algorithm>
#include <numbers>

#include "fluxgs/math/spherical_harmonics.h"
#include "trainer/compress/adaptive_degree.h"
#include "trainer/compress/fit_splats.h"
#include "trainer/compress/sphere_prior.h"
#include "trainer/core/psnr.h"
#include "trainer/paper/energy_moments.h"

namespace fluxgs {
namespace {

void keep_rows(TrainState& state, int degree) {
  state.adam.first = rows_of_degree(state.adam.first, degree);
  state.adam.second = rows_of_degree(state.adam.second, degree);
}

/// The rule named by the options; they have been validated.
SphereRule rule_of(const TrainOptions& options) {
  return sphere_rule(options.quadrature, options.samples, options.seed).value();
}

/// Adds the projection of max(0, residual) onto degree 0 and 1: with Y₀ and Y₁ the basis functions'
/// constants, 4π·Y₀·E_mag and 4π·Y₁·E_dir (order −y, z, −x). "Monte Carlo directional moments
/// largely match 1st-order SH" (paper, Insight 1), taken literally.
void add_projection(const PlanarFloats& energy, PlanarFloats& parameters) {
  constexpr double k4Pi = 4 * std::numbers::pi;
  const auto y0 = static_cast<float>(k4Pi * math::kSh0), y1 = static_cast<float>(k4Pi * math::kSh1);
  constexpr int kAxis[] = {1, 2, 0};  // y, z, x
  constexpr float kSign[] = {-1, 1, -1};
  for (int c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      parameters.row(row::sh_dc + c)[i] += y0 * energy.row(c)[i];
      for (int k = 0; k < 3; ++k)
        parameters.row(row::sh_rest + 3 * k + c)[i] +=
            kSign[k] * y1 * energy.row(3 + 3 * kAxis[k] + c)[i];
    }
}

/// Rows sh_dc and sh_rest of degree 1.
PlanarFloats first_order(const PlanarFloats& parameters) {
  PlanarFloats rows(networks::kShColumns, parameters.size());
  for (int r = 0; r < rows.rows(); ++r)
    std::copy_n(parameters.row(row::sh_dc + r), parameters.size(), rows.row(r));
  return rows;
}

/// Turns the SH of degree 1 that the parameters have by now into what networks make of
/// latents: `energy`, or without Ψ the SH coefficients themselves.
PsiFitReport introduce_networks(TrainState& state, const TrainOptions& options, PlanarFloats energy,
                                const Threads& threads) {
  const bool psi = energy.rows() > 0;
  NetworkState networks{
      make_appearance_model(psi, options.phi == Switch::on, measure_normalisation(state.parameters),
                            options.seed),
      {},
      {}};
  const PlanarFloats target = first_order(state.parameters);
  networks.latents = psi ? std::move(energy) : target;
  // Without Ψ, the optimiser goes on with the coefficients it knows
  networks.adam = psi ? AdamState{PlanarFloats(target.rows(), target.size()),
                                  PlanarFloats(target.rows(), target.size())}
                      : AdamState{first_order(state.adam.first), first_order(state.adam.second)};
  PsiFitReport report;
  if (psi && options.psi_fit_steps > 0)
    report = fit_psi(
        networks.model, state.parameters, networks.latents, target,
        {.steps = options.psi_fit_steps, .rate = options.psi_rate, .seed = options.seed}, threads);
  state.networks = std::move(networks);
  return report;
}

void reduce_to_one_degree(TrainState& state, const TrainOptions& options, const ViewWeights& views,
                          double prior, const Threads& threads, ReductionReport& report) {
  const int degree = target_degree(options);
  PlanarFloats energy;
  if (options.sh_reduce == ShReduction::energy)
    energy = energy_moments(state.parameters, options.residual, rule_of(options), threads);
  switch (options.sh_reduce) {
    case ShReduction::view_ls:
      state.parameters = fit_to_views(state.parameters, degree, views, prior, threads);
      break;
    case ShReduction::uniform_ls:
      state.parameters = fit_to_sphere(state.parameters, degree, rule_of(options), threads);
      break;
    default:
      state.parameters = rows_of_degree(state.parameters, degree);
  }
  keep_rows(state, degree);
  const bool psi = makes_psi(options);
  if (energy.rows() > 0 && !psi) add_projection(energy, state.parameters);
  if (psi || makes_phi(options))
    report.psi =
        introduce_networks(state, options, psi ? std::move(energy) : PlanarFloats(), threads);
}

}  // namespace

ReductionReport reduce_appearance(TrainState& state, const TrainOptions& options,
                                  const ViewWeights& views, double train_mse,
                                  const Threads& threads) {
  const std::size_t size = state.parameters.size();
  const bool adaptive = options.sh_target == ShTarget::adaptive;
  const double prior = best_sphere_prior(state.parameters, views, threads);
  const Unexplained unexplained = unexplained_variance(state.parameters, views, prior, threads);
  Unexplained dropped = unexplained;
  dropped.fitted = dropped.truncated;
  ReductionReport report;
  report.sphere_prior = prior;
  std::vector<std::uint8_t> degrees(size, static_cast<std::uint8_t>(target_degree(options)));
  if (adaptive)
    degrees = min_degrees(unexplained, threshold_for(unexplained, views.pixels,
                                                     added_mse(train_mse, options.sh_loss)));
  report.dropped = degree_loss(dropped, degrees, views.pixels);
  report.unexplained = degree_loss(unexplained, degrees, views.pixels);
  for (std::uint8_t d : degrees) ++report.degrees[d];

  if (adaptive) {
    state.parameters = fit_to_views(state.parameters, degrees, views, prior, threads);
    state.degrees = std::move(degrees);
  } else {
    reduce_to_one_degree(state, options, views, prior, threads, report);
  }
  return report;
}

}  // namespace fluxgs
