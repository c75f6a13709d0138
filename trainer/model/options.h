// Every constant of training, once. The command line can set each of them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "trainer/model/choices.h"

namespace fluxgs {

/// Defaults: those of vanilla 3DGS (Kerbl et al. 2023, section 5 and appendix), but for the opacity
/// rate (0.05 there in the first release), densification every 500 instead of 100 iterations, and
/// an SH curriculum that a short run finishes too. Measured on a capture of 84 images at 200×149,
/// 2,000 iterations: every 500, 29.84 dB with 32 k splats; every 100, 29.92 dB with 58 k; one SH
/// degree per 1,000 iterations costs 0.8 dB. Presets (see preset()) change them.
///
/// Iterations at which something happens may be 0 for "depends on the length of the run"; see
/// resolved(). "Paper" is the Flux-GS paper, with the section.
struct TrainOptions {
  int iterations = 30000;
  std::uint64_t seed = 1;

  // Appearance
  int sh_degree = 3;           ///< 0…3, until the switch
  int sh_degree_interval = 0;  ///< iterations until the degree in use grows by one; 0: an eighth
                               ///< of the run, at most 1,000 (3DGS) and a
                               ///< quarter of the time before the switch

  /// SH coefficients of the finished scene (paper, "Training Curriculum"). Until the switch
  /// sh_degree.
  ShTarget sh_target = ShTarget::degree_3;
  ShReduction sh_reduce = ShReduction::view_ls;
  int switch_iteration = 0;  ///< 0: a tenth of the run, at most 3,000 (paper); adaptive: 7/10
  Residual residual = Residual::from_1;           ///< of the energy moments
  Quadrature quadrature = Quadrature::fibonacci;  ///< of the energy moments
  int samples = 128;                              ///< K, directions of the quadrature
  Switch psi = Switch::on;   ///< energy: a network makes c′; off: their projection is added
  Switch phi = Switch::off;  ///< a network adds offsets (paper, "Gaussian Attribute Awareness")
  int psi_fit_steps = 500;   ///< in which Ψ learns known colours before training goes on
  double psi_rate = 0.01;    ///< learning rate of Ψ, see NetworkRates
  double phi_rate = 1e-3;    ///< of Φ
  double sh_loss = 0.1;      ///< adaptive: dB that the reduction may cost, at most

  // Learning rates, per step
  double position_rate = 1.6e-4;        ///< × scene extent, at the start
  double position_rate_final = 1.6e-6;  ///< × scene extent, after position_decay steps; log-linear
  int position_decay = 30000;  ///< steps; fixed in 3DGS, so short runs end with a higher rate
  double sh_dc_rate = 2.5e-3;  ///< of SH coefficients
  double sh_rest_rate = 2.5e-3 / 20;
  double opacity_rate = 0.025;   ///< of logits
  double log_scale_rate = 5e-3;  ///< of natural logarithms
  double rotation_rate = 1e-3;   ///< of quaternions' components

  // Adam
  double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-15;

  double lambda_dssim = 0.2;  ///< weight of 1 − SSIM in the loss, 0…1
  double opacity_weight = 0;  ///< of the mean opacity in the loss (Kheradmand et al. 2024)
  double scale_weight = 0;    ///< of the mean standard deviation in the loss, the same

  /// Splats hidden at random in each step: this / the number of training views of them, 0.2 at
  /// most, at the end of the run, none at its start (Park et al. 2025). 0: off
  double dropout = 0;

  // Coarse to fine: images are first halved `coarse_levels` times, then once less, …
  int coarse_levels = 0;  ///< 0…4
  int coarse_until = 0;   ///< iteration of the first full size; 0: 3/10 of the run

  // Densification (3DGS, section 5.2; paper, "Accurate Densification")
  Densify densify = Densify::grad;
  int densify_from = 500;          ///< first iteration at which splats are added
  int densify_until = 0;           ///< last one; 0: half of the iterations, at most 15,000
  int densify_interval = 500;      ///< iterations; 0: a hundredth of the run, at least 50
  double densify_gradient = 2e-4;  ///< mean |∂L/∂centre| in normalised device coordinates
  double densify_size = 0.01;      ///< × scene extent: smaller splats are cloned, larger ones split
  Split split = Split::random;
  double split_shrink = 1.6;  ///< a split splat's scale is divided by this
  double densify_growth = 0;  ///< at most this × the splats are added at once; 0: no limit
  GrowthRank growth_rank = GrowthRank::gradient;
  std::uint64_t max_splats = 0;     ///< 0: no limit
  std::uint64_t max_memory = 0;     ///< MiB of the program, by estimate; 0: no limit
  std::uint64_t target_splats = 0;  ///< splats at the end, whatever the gradients; 0: no target

  // Scores over several views (paper, "Multi-view Alpha-based Densification and Pruning")
  int score_cameras = 6;  ///< views
  CameraSampling camera_sampling = CameraSampling::stratified;
  int azimuth_bins = 12, elevation_bins = 6;  ///< M_θ, M_φ of stratified sampling
  ScoreWeight score_weight = ScoreWeight::alpha;
  ScoreLoss score_loss = ScoreLoss::l1_dssim;
  ScoreUnit score_unit = ScoreUnit::percentile;
  ScoreShare score_share = ScoreShare::pixel;
  double tau_plus = 0.1, tau_minus = 0.01;           ///< τ⁺, τ⁻, in score_unit
  double quantile_plus = 0.6, quantile_minus = 0.1;  ///< Q⁺, Q⁻, 0…1

  // Pruning
  Prune prune = Prune::opacity;
  double prune_opacity = 0.005;  ///< 0…1: fainter splats go
  /// px, applies after the first opacity reset; 0: never. Off, as it is in effect in the first
  /// release of 3DGS, which clears its radii before it compares them. 20, the value in the paper's
  /// code, costs 2.6 dB on the quickstart's capture at 7,000 iterations: walls are large splats.
  double prune_screen_radius = 0;
  double prune_world_size = 0.1;      ///< × scene extent; after the first opacity reset; 0: never
  int opacity_reset_interval = 3000;  ///< iterations, before the last densification; 0: never
  double opacity_reset_to = 0.01;     ///< 0…1, at most
  double opacity_cap = 1;  ///< opacities are limited to this after each densification but MCMC's

  // Late pruning, now and then; by opacity when no splats are added any more
  LatePrune late_prune = LatePrune::off;
  /// Iteration; 0: a fifth of the run (contribution), an interval after the last densification
  /// (opacity)
  int late_prune_from = 0;
  int late_prune_interval = 0;      ///< iterations; 0: a tenth of the run
  int late_prune_until = 0;         ///< last iteration; 0: 2/3 of the run, with opacity 9/10
  double late_prune_opacity = 0.1;  ///< opacity: splats below may be removed
  double late_prune_share = 0.01;   ///< contribution: of all α·T, removed each time

  // MCMC (Kheradmand et al. 2024)
  double mcmc_growth = 0.05;  ///< × the splats there are, at each densification
  double mcmc_noise = 5e5;    ///< × the rate of positions

  // Storing as a compact file (paper, "Attributes Compression")
  double store_loss = 0.3;  ///< dB of the training views' PSNR that rounding costs, at first
  double store_psnr = 0;    ///< dB to the scene's images that are enough all the same; 0: none are
  Switch rounding = Switch::off;  ///< train on with rounded parameters
  int round_from = 0;             ///< iteration; 0: after 9/10 of the run
  int round_interval =
      0;  ///< iterations until rounded anew; 0: a thousandth of the run, at least 20

  // Start
  std::uint64_t initial_splats = 0;  ///< every n-th point, so that they are this many; 0: all
  double initial_opacity = 0.1;      ///< 0…1

  /// RenderOptions::depth_spread_max of the training's images; 0: no limit, as in 3DGS
  double depth_spread = 0;
  RenderOptions render;
};

/// The same with every 0 that stands for "depends on the length of the run" replaced.
TrainOptions resolved(TrainOptions options);

/// The degree that every splat ends with; adaptive: the highest.
int target_degree(const TrainOptions& options);

/// Whether SH coefficients are reduced at some iteration.
bool reduces_appearance(const TrainOptions& options);

/// The highest degree that is trained before that.
int degree_before_switch(const TrainOptions& options);

/// Whether Ψ, and Φ, make the colours after it; of options that validate() takes.
bool makes_psi(const TrainOptions& options);
bool makes_phi(const TrainOptions& options);

/// Names of the presets, the default one first.
std::vector<std::string> preset_names();

/// The options of a preset: "flux" (our best), "flux-paper" (the paper to the letter), "3dgs"
/// (vanilla: SH of degree 3, single-view gradients), "3dgs-sh1" (the same with SH coefficients cut
/// off at the first degree).
Expected<TrainOptions> preset(std::string_view name);

/// Checks every option's range; the error names the option and the range.
Expected<void> validate(const TrainOptions& options);

/// An enumeration among the options.
struct OptionChoice {
  std::span<const std::string_view> names;  ///< empty: the option is a number
  int (*get)(const TrainOptions&) = nullptr;
  void (*set)(TrainOptions&, int) = nullptr;
};

/// One of the options by name, for the command line, reports and checkpoints.
struct OptionField {
  const char* name;  ///< as on the command line, without the dashes
  const char* help;
  double low, high;  ///< accepted range of a number
  // exactly one of these four is set
  int TrainOptions::* integer = nullptr;
  double TrainOptions::* real = nullptr;
  std::uint64_t TrainOptions::* natural = nullptr;
  OptionChoice choice = {};
};

const std::vector<OptionField>& option_fields();

}  // namespace fluxgs
