// The method's parts that can be exchanged: each choice is an enumeration and its names on the
// command line, in reports and in checkpoints.
#pragma once

#include <array>
#include <string_view>

#include "trainer/model/appearance_choices.h"
#include "trainer/raster/score.h"

namespace fluxgs {

/// SH degree that a finished scene has; adaptive: each splat its own.
enum class ShTarget { degree_1, degree_0, degree_2, degree_3, adaptive };
inline constexpr std::array<std::string_view, 5> kShTargetNames = {"1", "0", "2", "3", "adaptive"};

/// Where splats are added.
enum class Densify {
  multiview,  ///< large gradients where several views see errors (paper, "Accurate Densification")
  grad,       ///< large gradients (Kerbl et al. 2023)
  mcmc,       ///< dead splats move to living ones (Kheradmand et al. 2024)
};
inline constexpr std::array<std::string_view, 3> kDensifyNames = {"multiview", "grad", "mcmc"};

/// Which of the splats that may be split or cloned come first where there is room for some only.
enum class GrowthRank { gradient, error };
inline constexpr std::array<std::string_view, 2> kGrowthRankNames = {"gradient", "error"};

/// How a splat becomes two.
enum class Split {
  random,     ///< drawn from its own distribution (Kerbl et al. 2023)
  long_axis,  ///< side by side along its longest axis (Deng et al. 2025)
};
inline constexpr std::array<std::string_view, 2> kSplitNames = {"random", "long-axis"};

/// Which splats are removed while others are added.
enum class Prune {
  multiview,  ///< transparent ones that have a part in well reconstructed pixels (paper)
  opacity,    ///< transparent ones
  none,
};
inline constexpr std::array<std::string_view, 3> kPruneNames = {"multiview", "opacity", "none"};

/// The loss that the metric maps are made of.
enum class ScoreLoss { l1, l1_dssim };
inline constexpr std::array<std::string_view, 2> kScoreLossNames = {"l1", "l1-dssim"};

/// Units of the thresholds τ± of the metric maps.
enum class ScoreUnit {
  percentile,  ///< the loss's 99.5th percentile in the image, but at least a floor
  raw,         ///< the loss itself
};
inline constexpr std::array<std::string_view, 2> kScoreUnitNames = {"percentile", "raw"};

/// What a splat's sums over pixels are divided by.
enum class ScoreShare {
  pixel,  ///< the pixels it covers; splats that no view saw do not count in quantiles
  sum,    ///< nothing, and every splat counts (the paper to the letter)
};
inline constexpr std::array<std::string_view, 2> kScoreShareNames = {"pixel", "sum"};

inline constexpr std::array<std::string_view, 2> kScoreWeightNames = {"alpha", "alpha-t"};

/// How the views that scores are taken from are chosen.
enum class CameraSampling { stratified, random };
inline constexpr std::array<std::string_view, 2> kCameraSamplingNames = {"stratified", "random"};

enum class Switch { off, on };
inline constexpr std::array<std::string_view, 2> kSwitchNames = {"off", "on"};

/// Which splats go now and then, late in the training.
enum class LatePrune {
  off,
  opacity,       ///< faint ones that have a part in well reconstructed pixels (design of the paper)
  contribution,  ///< those that together add the least to all training images, for their cost
};
inline constexpr std::array<std::string_view, 3> kLatePruneNames = {"off", "opacity",
                                                                    "contribution"};

}  // namespace fluxgs
