// Densification: the strategy that adds splats and removes others, for the first part of a
// training.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "trainer/model/phase.h"

namespace fluxgs {

/// Choice of the places where splats are added.
enum class Densify {
  multiview,  ///< large gradients where several views see errors (paper, "Accurate Densification")
  gradient,   ///< large gradients (Kerbl et al. 2023)
  mcmc,       ///< dead splats move to living ones (Kheradmand et al. 2024)
};
inline constexpr std::array<std::string_view, 3> kDensifyNames = {"multiview", "gradient", "mcmc"};

/// Order of the splats that may be split or cloned, where there is room for some only.
enum class GrowthRank { gradient, error };
inline constexpr std::array<std::string_view, 2> kGrowthRankNames = {"gradient", "error"};

/// Ways to make two splats of one.
enum class Split {
  random,     ///< drawn from its own distribution (Kerbl et al. 2023)
  long_axis,  ///< side by side along its longest axis (Deng et al. 2025)
};
inline constexpr std::array<std::string_view, 2> kSplitNames = {"random", "long-axis"};

/// Choice of the splats that are removed while others are added.
enum class Prune {
  multiview,  ///< transparent ones that have a part in well reconstructed pixels (paper)
  opacity,    ///< transparent ones
  none,
};
inline constexpr std::array<std::string_view, 3> kPruneNames = {"multiview", "opacity", "none"};

/// 3DGS, section 5.2; paper, "Accurate Densification". Every 500 instead of 100 iterations:
/// measured on a capture of 84 views at 200×149, 2,000 iterations: every 500, 29.84 dB with 32 k
/// splats; every 100, 29.92 dB with 58 k.
struct DensificationOptions {
  static constexpr const char* kTitle = "Densification";
  Densify strategy = Densify::gradient;
  int from = 500;          ///< first iteration at which splats are added
  int until = 0;           ///< last one; 0: half of the iterations, at most 15,000
  int interval = 500;      ///< iterations; 0: a hundredth of the run, at least 50
  double gradient = 2e-4;  ///< mean |∂L/∂centre| in normalised device coordinates
  double loss = 0;         ///< multiview: SplatScores::loss at which `gradient` holds; 0: at any
  double worth = 0;  ///< dB: smaller gradients suffice above this TrainState::splat_worth; 0: never
  double size = 0.01;  ///< × scene extent: smaller splats are cloned, larger ones split
  Split split = Split::random;
  double split_shrink = 1.6;  ///< a split splat's scale is divided by this
  double growth = 0;          ///< at most this × the splats are added at once; 0: no limit
  GrowthRank growth_rank = GrowthRank::gradient;

  Prune prune = Prune::opacity;
  double prune_opacity = 0.005;  ///< 0…1: splats of lower opacity are removed
  /// px, applies after the first opacity reset; 0: never. Off, as it is in effect in the first
  /// release of 3DGS, which clears its radii before it compares them. 20, the value in the paper's
  /// code, costs 2.6 dB on the quickstart's capture at 7,000 iterations: walls are large splats.
  double prune_screen_radius = 0;
  double prune_world_size = 0.1;  ///< × scene extent; after the first opacity reset; 0: never
  double opacity_cap = 1;  ///< opacities are limited to this after each densification but MCMC's

  double mcmc_growth = 0.05;  ///< × the splats there are, at each densification
  double mcmc_noise = 5e5;    ///< × the learning rate of positions

  OptionFields fields(const TrainOptions& all);
};

/// Resolves the options. Null where nothing is ever added.
std::unique_ptr<Phase> make_densification(TrainOptions& options);

/// The noise of MCMC on positions; null for other strategies. After make_densification().
std::unique_ptr<Phase> make_position_noise(TrainOptions& options);

}  // namespace fluxgs
