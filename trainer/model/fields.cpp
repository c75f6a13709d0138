#include "trainer/model/options.h"

#include "trainer/core/quadrature.h"

#include <type_traits>

#include <fmt/format.h>

namespace fluxgs {
namespace {

constexpr double kMany = 1e9;

OptionField whole(const char* name, const char* help, int TrainOptions::* field, double low,
                  double high) {
  return {.name = name, .help = help, .low = low, .high = high, .integer = field};
}
OptionField real(const char* name, const char* help, double TrainOptions::* field, double low,
                 double high) {
  return {.name = name, .help = help, .low = low, .high = high, .real = field};
}
OptionField natural(const char* name, const char* help, std::uint64_t TrainOptions::* field) {
  return {.name = name, .help = help, .low = 0, .high = 1.9e19, .natural = field};
}
template <auto member, auto& names>
OptionField choice(const char* name, const char* help) {
  return {.name = name,
          .help = help,
          .low = 0,
          .high = static_cast<double>(names.size() - 1),
          .choice = {names,
                     [](const TrainOptions& options) { return static_cast<int>(options.*member); },
                     [](TrainOptions& options, int value) {
                       options.*member =
                           static_cast<std::remove_reference_t<decltype(options.*member)>>(value);
                     }}};
}

double value_of(const TrainOptions& options, const OptionField& f) {
  if (f.integer) return options.*f.integer;
  if (f.real) return options.*f.real;
  if (f.choice.get) return f.choice.get(options);
  return static_cast<double>(options.*f.natural);
}

}  // namespace

const std::vector<OptionField>& option_fields() {
  using O = TrainOptions;
  static const std::vector<OptionField> fields = {
      whole("iterations", "training steps", &O::iterations, 1, kMany),
      natural("seed", "random seed", &O::seed),
      whole("sh-degree", "SH degree", &O::sh_degree, 0, 3),
      whole("sh-degree-interval",
            "steps until the degree in use grows by one (0: an eighth of the steps, at most 1000 "
            "and a quarter of those before SH coefficients are reduced)",
            &O::sh_degree_interval, 0, kMany),
      choice<&O::sh_target, kShTargetNames>(
          "sh-target", "degree of the finished scene; adaptive: each splat its own"),
      choice<&O::sh_reduce, kShReductionNames>("sh-reduce",
                                               "how SH coefficients lose their degrees"),
      whole("switch-iter",
            "step of the reduction (0: a tenth of the steps, at most 3000; adaptive: 7/10)",
            &O::switch_iteration, 0, kMany),
      choice<&O::residual, kResidualNames>("residual", "which bands the energy moments are of"),
      choice<&O::quadrature, kQuadratureNames>("quadrature", "how moments are integrated"),
      whole("samples", "directions of the quadrature", &O::samples, 1, kMaxSphereSamples),
      choice<&O::psi, kSwitchNames>("psi", "energy moments become colours by a network"),
      choice<&O::phi, kSwitchNames>("phi", "a network adds offsets to the colours"),
      whole("psi-fit-steps", "steps in which psi learns known colours first", &O::psi_fit_steps, 0,
            1e6),
      real("psi-rate", "learning rate of psi", &O::psi_rate, 0, 1),
      real("phi-rate", "learning rate of phi", &O::phi_rate, 0, 1),
      real("sh-loss", "dB that adaptive degrees may cost, at most", &O::sh_loss, 0, 10),
      real("position-rate", "learning rate of positions, x scene extent", &O::position_rate, 0, 1),
      real("position-rate-final", "the same after --position-decay steps", &O::position_rate_final,
           1e-12, 1),
      whole("position-decay", "steps over which the rate of positions falls", &O::position_decay, 1,
            kMany),
      real("sh-dc-rate", "learning rate of the constant colour", &O::sh_dc_rate, 0, 1),
      real("sh-rest-rate", "learning rate of the other coefficients", &O::sh_rest_rate, 0, 1),
      real("opacity-rate", "learning rate of opacity logits", &O::opacity_rate, 0, 10),
      real("log-scale-rate", "learning rate of log-scales", &O::log_scale_rate, 0, 1),
      real("rotation-rate", "learning rate of quaternions", &O::rotation_rate, 0, 1),
      real("beta1", "Adam: decay of the first moment", &O::beta1, 0, 0.999999),
      real("beta2", "Adam: decay of the second moment", &O::beta2, 0, 0.9999999),
      real("epsilon", "Adam: added to the denominator", &O::epsilon, 1e-30, 1),
      real("lambda-dssim", "weight of 1 - SSIM in the loss", &O::lambda_dssim, 0, 1),
      real("opacity-weight", "weight of the mean opacity in the loss", &O::opacity_weight, 0, 10),
      real("scale-weight", "weight of the mean standard deviation in the loss", &O::scale_weight, 0,
           10),
      real("dropout",
           "share of the splats that a step hides at the end, x training images (0: off)",
           &O::dropout, 0, 1000),
      whole("coarse-levels", "images are first halved so often", &O::coarse_levels, 0, 4),
      whole("coarse-until", "step of the first full-size images (0: 3/10 of the steps)",
            &O::coarse_until, 0, kMany),
      choice<&O::densify, kDensifyNames>(
          "densify", "where splats are added: multiview (gradients and errors), grad or mcmc"),
      whole("densify-from", "first step at which splats are added", &O::densify_from, 0, kMany),
      whole("densify-until",
            "last step at which splats are added (0: half of the steps, at most 15000)",
            &O::densify_until, 0, kMany),
      whole("densify-interval",
            "steps between densifications (0: a hundredth of them, at least 50)",
            &O::densify_interval, 0, kMany),
      real("densify-gradient", "screen-space gradient above which a splat is cloned or split",
           &O::densify_gradient, 0, kMany),
      real("densify-size", "size that separates cloning from splitting, x scene extent",
           &O::densify_size, 0, kMany),
      real("split-shrink", "scales are divided by this when a splat is split", &O::split_shrink, 1,
           100),
      choice<&O::split, kSplitNames>("split", "how a large splat becomes two"),
      real("densify-growth", "at most this x the splats are added at once (0: no limit)",
           &O::densify_growth, 0, kMany),
      choice<&O::growth_rank, kGrowthRankNames>(
          "growth-rank", "which come first where there is room for some only"),
      natural("max-splats", "never more splats than this (0: no limit)", &O::max_splats),
      natural("max-memory", "MiB that training may take: no splats are added beyond (0: no limit)",
              &O::max_memory),
      natural("target-splats", "splats at the end, whatever the gradients (0: no target)",
              &O::target_splats),
      whole("cameras", "views that scores are taken from", &O::score_cameras, 1, 1000),
      choice<&O::camera_sampling, kCameraSamplingNames>("camera-sampling",
                                                        "how these views are chosen"),
      whole("azimuth-bins", "bins of stratified cameras around the z axis of the data set",
            &O::azimuth_bins, 1, 1000),
      whole("elevation-bins", "bins of stratified cameras from below to above", &O::elevation_bins,
            1, 1000),
      choice<&O::score_weight, kScoreWeightNames>("score", "weight of a splat in a pixel"),
      choice<&O::score_loss, kScoreLossNames>("score-loss", "loss in the metric maps"),
      choice<&O::score_unit, kScoreUnitNames>("score-unit", "unit of --tau-plus and --tau-minus"),
      choice<&O::score_share, kScoreShareNames>("score-share",
                                                "scores per covered pixel, or their sums"),
      real("tau-plus", "pixels with a larger loss are badly reconstructed", &O::tau_plus, 0, kMany),
      real("tau-minus", "pixels with a smaller loss are well reconstructed", &O::tau_minus, 0,
           kMany),
      real("quantile-plus", "splats above this quantile of S+ may be cloned or split",
           &O::quantile_plus, 0, 1),
      real("quantile-minus", "transparent splats above this quantile of S- are removed",
           &O::quantile_minus, 0, 1),
      choice<&O::prune, kPruneNames>(
          "prune", "which splats are removed at densifications (mcmc: moves the faint instead)"),
      real("prune-opacity", "splats below this opacity are removed", &O::prune_opacity, 0, 1),
      real("prune-screen-radius",
           "px; larger splats are removed after the first opacity reset (0: never)",
           &O::prune_screen_radius, 0, kMany),
      real("prune-world-size",
           "x scene extent; larger splats are removed after the first opacity reset (0: never)",
           &O::prune_world_size, 0, kMany),
      whole("opacity-reset-interval",
            "steps between opacity resets, until the last densification (0: never; mcmc: never)",
            &O::opacity_reset_interval, 0, kMany),
      real("opacity-reset-to", "opacity after a reset", &O::opacity_reset_to, 1e-4, 0.99),
      real("opacity-cap",
           "opacities are limited to this after each densification but those of mcmc",
           &O::opacity_cap, 0.01, 1),
      choice<&O::late_prune, kLatePruneNames>("late-prune",
                                              "which splats go now and then, late in the training"),
      whole(
          "late-prune-from",
          "first step of late pruning (0: a fifth of the steps; by opacity: an interval after the "
          "last densification)",
          &O::late_prune_from, 0, kMany),
      whole("late-prune-interval", "steps between late prunings (0: a tenth of the steps)",
            &O::late_prune_interval, 0, kMany),
      whole("late-prune-until",
            "last step of late pruning (0: 2/3 of the steps, with opacity 9/10)",
            &O::late_prune_until, 0, kMany),
      real("late-prune-opacity", "late pruning by opacity removes splats below this",
           &O::late_prune_opacity, 0, 1),
      real("late-prune-share", "late pruning by contribution removes this part of all alpha x T",
           &O::late_prune_share, 0, 1),
      real("mcmc-growth", "x the splats there are, added at each densification", &O::mcmc_growth, 0,
           10),
      real("mcmc-noise", "noise of positions, x their rate", &O::mcmc_noise, 0, 1e12),
      real(
          "store-loss",
          "dB of PSNR that a compact file costs before training makes up for it (an estimate: what "
          "rounding changes is taken to be independent of the scene's own errors)",
          &O::store_loss, 0.001, 10),
      real("store-psnr",
           "dB that the file's images need be from the scene's, whatever --store-loss (0: no "
           "limit)",
           &O::store_psnr, 0, 100),
      choice<&O::rounding, kSwitchNames>("rounding",
                                         "train on with the numbers that a compact file holds "
                                         "(a preset's choice counts only where OUT is a .glb)"),
      whole("round-from",
            "from this step on, or from when densification and the reduction of SH coefficients "
            "are over "
            "(0: 9/10 of the steps)",
            &O::round_from, 0, kMany),
      whole("round-interval",
            "steps until they are rounded anew (0: a thousandth of the steps, at least 20)",
            &O::round_interval, 0, kMany),
      real("depth-spread",
           "x their depth; splats that extend farther along the view are not drawn (0: all are)",
           &O::depth_spread, 0, kMany),
      natural("initial-splats", "so many of the points become splats (0: all)", &O::initial_splats),
      real("initial-opacity", "opacity of the first splats", &O::initial_opacity, 1e-3, 0.99),
  };
  return fields;
}

namespace {

/// What the parts of the method ask of each other.
Expected<void> validate_together(const TrainOptions& o) {
  const bool first_order = o.sh_target == ShTarget::degree_1 && o.sh_degree >= 1;
  const char* expected =
      o.sh_degree >= 1 ? "expected --sh-target 1" : "expected a --sh-degree of 1 or more";
  if (o.phi == Switch::on && !first_order)
    return fail("", "--phi", fmt::format("makes colours of degree 1 only, {}", expected));
  if (o.sh_reduce == ShReduction::energy && !first_order)
    return fail("", "--sh-reduce",
                fmt::format("energy makes colours of degree 1 only, {}", expected));
  if (o.sh_target == ShTarget::adaptive && o.sh_reduce != ShReduction::view_ls)
    return fail("", "--sh-target", "adaptive degrees are fitted, expected --sh-reduce view-ls");
  const bool integrates =
      o.sh_reduce == ShReduction::energy || o.sh_reduce == ShReduction::uniform_ls;
  if (integrates && o.quadrature == Quadrature::lebedev && o.samples > kMaxLebedevSamples)
    return fail("", "--samples",
                fmt::format("{} are too many for --quadrature lebedev, expected {} at most",
                            o.samples, kMaxLebedevSamples));
  return {};
}

}  // namespace

Expected<void> validate(const TrainOptions& options) {
  for (const OptionField& f : option_fields()) {
    const double value = value_of(options, f);
    if (!(value >= f.low && value <= f.high))
      return fail("", fmt::format("--{}", f.name),
                  fmt::format("{:g} is out of range, expected {:g} to {:g}", value, f.low, f.high));
  }
  return validate_together(options);
}

}  // namespace fluxgs
