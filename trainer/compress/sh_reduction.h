// SH reduction: from SH of degree 3 to the degree that the finished scene has (paper, "Training
// Curriculum"), by one degree for all splats or the lowest that is good enough for each.
#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "trainer/compress/view_weights.h"
#include "trainer/core/quadrature.h"
#include "trainer/model/phase.h"

namespace fluxgs {

/// SH degree of the finished scene; adaptive: each splat its own.
enum class ShTarget { degree_1, degree_0, degree_2, degree_3, adaptive };
inline constexpr std::array<std::string_view, 5> kShTargetNames = {"1", "0", "2", "3", "adaptive"};

/// Ways from splats of degree 3 to splats of a lower degree.
enum class ShReduction {
  view_ls,     ///< least squares over the directions from which each splat is seen (fit_splats.h)
  truncate,    ///< the higher bands are dropped
  uniform_ls,  ///< least squares over the whole sphere: truncation, but for the quadrature's error
  energy,      ///< the paper's: truncation and energy moments (paper/network_colors.h)
  none         ///< no reduction: the target degree is trained from the beginning
};
inline constexpr std::array<std::string_view, 5> kShReductionNames = {
    "view-ls", "truncate", "uniform-ls", "energy", "none"};

struct ShReductionOptions {
  static constexpr const char* kTitle = "SH reduction";
  ShTarget target = ShTarget::degree_3;
  ShReduction reduce = ShReduction::view_ls;
  int iteration = 0;           ///< 0: a tenth of the run, at most 3,000 (paper); adaptive: 7/10
  double max_psnr_drop = 0.1;  ///< adaptive: dB that the reduction may cost, at most
  Quadrature quadrature = Quadrature::fibonacci;  ///< of uniform_ls and energy
  int samples = 128;                              ///< K, directions of the quadrature

  OptionFields fields(const TrainOptions& all);
  Expected<void> validate(const TrainOptions& all) const;
};

/// The degree that every splat ends with; adaptive: the highest.
int target_sh_degree(const TrainOptions& options);

/// True if degrees are reduced at some iteration.
bool reduces_sh(const TrainOptions& options);

/// The degree that every splat starts with.
int first_sh_degree(const TrainOptions& options);

/// Resolves the iteration of the reduction and returns it, also where nothing is reduced.
int sh_reduce_iteration(TrainOptions& options);

/// The quadrature of the options, which are valid.
SphereRule sphere_rule_of(const TrainOptions& options);

/// Effect of a reduction, as far as the training views see it.
struct ReductionReport {
  double dropped = 0;           ///< MSE bound (adaptive_degree.h) if the higher bands were dropped
  double unexplained = 0;       ///< MSE bound of the fits of the chosen degrees
  std::size_t degrees[4] = {};  ///< splats by degree
  double sphere_prior = 0;      ///< of the fits (sphere_prior.h)
};

/// Reduces the parameters and the optimiser's moments to the target. Positions, shapes, opacities
/// and the moments of all that stays are kept. `train_mse`: the current mean square error over the
/// training views, by which adaptive degrees are measured.
ReductionReport reduce_sh(TrainState& state, const TrainOptions& options, const ViewWeights& views,
                          double train_mse, const Threads& threads);

/// Null where nothing is reduced.
std::unique_ptr<Phase> make_sh_reduction(TrainOptions& options);

}  // namespace fluxgs
