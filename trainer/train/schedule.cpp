#include "trainer/train/schedule.h"

#include <algorithm>
#include <initializer_list>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trainer/compress/compression.h"
#include "trainer/compress/sh_reduction.h"
#include "trainer/densify/camera_clearance.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/dropout.h"
#include "trainer/densify/late_pruning.h"
#include "trainer/densify/mask_pruning.h"
#include "trainer/densify/opacity_reset.h"
#include "trainer/densify/penalties.h"
#include "trainer/paper/network_colors.h"
#include "trainer/train/antialiasing.h"
#include "trainer/train/carving.h"
#include "trainer/train/progressive_resolution.h"
#include "trainer/train/sh_curriculum.h"

namespace fluxgs {

namespace {

/// Inverse to the length of the run, from 3DGS's rate to four times that
/// (docs/method/experiments.md).
double scale_lr_of(int iterations) { return std::clamp(140.0 / iterations, 0.005, 0.02); }

}  // namespace

// Phases are made in the order in which they depend on each other's options, and run in the order
// of the list at the end.
Schedule make_schedule(TrainOptions options, const std::vector<View>& views,
                       const Threads& threads) {
  if (options.scale_lr == 0) options.scale_lr = scale_lr_of(options.iterations);
  auto resolution = make_progressive_resolution(options, views);
  auto antialiasing = make_antialiasing(options, views);
  auto carving = make_carving(options, views);
  auto dropout = make_dropout(options);
  auto penalties = make_penalties(options);
  auto densification = make_densification(options);
  auto noise = make_position_noise(options);
  const int densify_until = options.get<DensificationOptions>().until;
  auto clearance = make_camera_clearance(options);
  auto reset = make_opacity_reset(options);
  auto mask_pruning = make_mask_pruning(options, views);
  auto late_pruning = make_late_pruning(options, densify_until);
  auto reduction = make_sh_reduction(options);
  auto networks = make_network_colors(options, threads);
  const int reduced_at = reduction || networks.colors ? sh_reduce_iteration(options) : 0;
  auto curriculum = make_sh_curriculum(options, first_sh_degree(options), reduced_at);

  Schedule schedule{std::move(options), {}};
  for (auto* phase :
       {&resolution, &curriculum, &carving, &dropout, &penalties, &noise,
        // Before splats are added, which shakes the image for a moment
        &networks.energy, &reduction, &networks.colors,
        // Late pruning before opacities are reset, after which they tell nothing
        &densification, &mask_pruning, &late_pruning, &clearance, &reset, &antialiasing})
    if (*phase) schedule.phases.push_back(std::move(*phase));
  return schedule;
}

Schedule plan_schedule(TrainOptions options) {
  static const std::vector<View> no_views;
  static const Threads one_thread(1);
  return make_schedule(std::move(options), no_views, one_thread);
}

int initial_sh_degree(const TrainOptions& options) { return first_sh_degree(options); }

int final_sh_degree(const TrainOptions& options) {
  return reduces_sh(options) ? target_sh_degree(options) : first_sh_degree(options);
}

TrainOptions default_options() {
  TrainOptions o;
  o.get<MaskOptions>();
  o.get<ProgressiveResolutionOptions>();
  o.get<ShCurriculumOptions>();
  o.get<AntialiasingOptions>();
  o.get<DropoutOptions>();
  o.get<PenaltyOptions>();
  o.get<DensificationOptions>();
  o.get<ScoreOptions>();
  o.get<CameraClearanceOptions>();
  o.get<OpacityResetOptions>();
  o.get<LatePruningOptions>();
  o.get<ShReductionOptions>();
  o.get<NetworkColorOptions>();
  o.get<CompressionOptions>();
  return o;
}

namespace {

/// Our best. What differs from vanilla 3DGS is there because a measurement says so.
TrainOptions flux() {
  TrainOptions o = default_options();
  // Few splats have to say more: SH coefficients learn four times as fast, and positions move on
  // until the cooldown
  o.position_lr_iterations = 45000;
  o.sh_rest_lr = 5e-4;
  // 3DGS's rate is too low for short runs: +0.5 dB on snowmiku after 7,000
  o.scale_lr = 0;
  // Fine texture: +0.1 dB and +0.003 SSIM on fox after 7,000, with about as many splats
  o.lambda_dssim = 0.3;
  // Values settle where several views want them: +0.25 dB and +0.003 SSIM on snowmiku after 7,000
  o.cooldown = 0.3;
  // Scenes are seen from nearer and farther than their photos: at half the resolution of the
  // training +1 to +6 dB, at a quarter +5 to +10, at twice +0.1 to +1.8, and less than 0.1 dB lost
  // at the same
  o.get<AntialiasingOptions>().antialias = true;
  o.get<AntialiasingOptions>().dilation = 0.1;
  // Twelve views: +1.1 dB on the test views, a third fewer bytes
  o.get<DropoutOptions>().dropout = 2.4;
  // No floaters that hide between two cameras
  o.get<CameraClearanceOptions>().clearance = 2;
  // A few new splats at a time, where several views see the most error, for half of the run
  auto& densification = o.get<DensificationOptions>();
  densification.strategy = Densify::multiview;
  densification.interval = 0;
  densification.gradient = 4.8e-4;
  // Scenes that match their images well are worth more splats (a wall of fine texture: +2 dB)
  densification.loss = 0.045;
  // and the more where late pruning shows that each of them counts
  densification.worth = 9;
  densification.growth = 0.15;
  densification.growth_rank = GrowthRank::error;
  densification.split = Split::long_axis;
  o.get<ScoreOptions>().weight = ScoreWeight::alpha_transmittance;
  o.get<ScoreOptions>().quantile_plus = 0;
  // Later iterations correct themselves on smaller images as well, in an eighth less time
  o.get<ProgressiveResolutionOptions>().levels = 1;
  // A quarter of the splats hardly shows
  o.get<LatePruningOptions>().mode = LatePrune::contribution;
  o.get<LatePruningOptions>().share = 0.003;
  // Late pruning finds useless splats. After a reset good ones come back too late (a wall of fine
  // texture: 1.2 dB after 30,000 iterations), and large ones are removed (a room's walls: 2.6 dB)
  o.get<OpacityResetOptions>().interval = 0;
  // Each splat its own degree, once they know what they look like
  o.get<ShReductionOptions>().target = ShTarget::adaptive;
  o.get<ShReductionOptions>().max_psnr_drop = 1;
  // Cheaper than as many decibels by more splats, but where all is fine texture
  o.get<CompressionOptions>().max_psnr_drop = 0.2;
  return o;
}

/// Vanilla 3DGS whose SH are cut off at the first degree.
TrainOptions vanilla_first_order() {
  TrainOptions o = default_options();
  o.get<ShReductionOptions>().target = ShTarget::degree_1;
  o.get<ShReductionOptions>().reduce = ShReduction::truncate;
  return o;
}

/// The paper to the letter, its faults included; what it leaves open is as in vanilla 3DGS. Two
/// things are not. Its supplement has two networks behind the energy, of one hidden layer each,
/// without saying what either makes; Ψ is one such network, as in the paper's own formula. Nor does
/// it say with what weights Ψ begins: ours is first taught the SH cut off, E moving with it
/// (fit_psi.h), after which it hardly matters how many directions E was averaged over.
TrainOptions paper() {
  TrainOptions o = default_options();
  // "Monte Carlo Specular Energy Aggregator", "Additional Implementation"
  auto& reduction = o.get<ShReductionOptions>();
  reduction.target = ShTarget::degree_1;
  reduction.reduce = ShReduction::energy;
  reduction.quadrature = Quadrature::mc;
  reduction.samples = 2048;
  o.get<NetworkColorOptions>().residual = Residual::from_2;
  o.get<NetworkColorOptions>().psi = true;
  o.get<NetworkColorOptions>().phi = true;
  // "Multi-view Alpha-based Densification and Pruning"
  o.get<DensificationOptions>().strategy = Densify::multiview;
  o.get<DensificationOptions>().prune = Prune::multiview;  // alone: the formula knows no size
  o.get<DensificationOptions>().prune_world_size = 0;
  auto& scores = o.get<ScoreOptions>();
  scores.weight = ScoreWeight::alpha;
  scores.loss = ScoreLoss::l1_dssim;
  scores.unit = ScoreUnit::raw;
  scores.normalization = ScoreNormalization::sum;
  return o;
}

struct Preset {
  const char* name;
  TrainOptions (*options)();
};

constexpr Preset kPresets[] = {
    {"flux", flux},
    {"flux-paper", paper},
    {"3dgs", default_options},
    {"3dgs-sh1", vanilla_first_order},
};

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& p : kPresets) names.emplace_back(p.name);
  return names;
}

Expected<TrainOptions> preset(std::string_view name) {
  for (const Preset& p : kPresets)
    if (name == p.name) return p.options();
  return fail(
      "", "--preset",
      fmt::format("'{}' is not a preset; expected {}", name, fmt::join(preset_names(), ", ")));
}

std::string plan_table(const Schedule& schedule) {
  const int n = schedule.options.iterations;
  std::string table =
      fmt::format("{:<16}{:<8}{:<30}{}\n", "iterations", "every", "phase", "effect");
  table += fmt::format("{:<16}{:<8}{:<30}{}\n", fmt::format("1-{}", n), 1, "optimization",
                       "renders a view, compares it with its image and moves all parameters");
  std::vector<const Phase*> phases;
  for (const auto& phase : schedule.phases) phases.push_back(phase.get());
  std::ranges::stable_sort(phases, {}, [](const Phase* phase) { return phase->period().first(); });
  for (const Phase* phase : phases) {
    const Period period = phase->period();
    const bool once = period.interval == 0;
    const int last = std::min(period.until, n);
    const std::string when =
        !period.takes_place(n) ? "never"
        : once                 ? fmt::format("{}", period.from)
               : fmt::format("{}-{}", period.first(), last - last % period.interval);
    table += fmt::format("{:<16}{:<8}{:<30}{}\n", when,
                         once ? "once" : fmt::format("{}", period.interval), phase->name(),
                         phase->effect());
  }
  return table;
}

}  // namespace fluxgs
