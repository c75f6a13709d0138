// Late pruning: now and then, the splats that add the least to the images are removed.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "trainer/densify/density_control.h"
#include "trainer/densify/splat_scores.h"
#include "trainer/model/phase.h"

namespace fluxgs {

/// Choice of the splats that are removed.
enum class LatePrune {
  off,
  opacity,       ///< transparent ones that have a part in well reconstructed pixels (paper)
  contribution,  ///< those that together add the least to all training images, for their cost
};
inline constexpr std::array<std::string_view, 3> kLatePruneNames = {"off", "opacity",
                                                                    "contribution"};

struct LatePruningOptions {
  static constexpr const char* kTitle = "Late pruning";
  LatePrune mode = LatePrune::off;
  int from = 0;      ///< iteration; 0: a fifth of the run, with opacity an interval after the last
                     ///< densification
  int interval = 0;  ///< iterations; 0: a tenth of the run
  int until = 0;     ///< last iteration; 0: 2/3 of the run, with opacity 9/10
  double opacity = 0.1;  ///< opacity: splats below may be removed
  double share = 0.01;   ///< contribution: of all α·T, removed each time
  int views = 0;         ///< contribution: sampled each time; 0: affordable_views() of the run

  OptionFields fields(const TrainOptions& all);
};

/// Removes splats by `mode`. For contribution the scores are those of views spread over the
/// training's, and the first to go contribute the least for their place in a file and the pixels
/// that are drawn for them; those that reach no pixel of these views stay, since others may see
/// them. Never below `target_splats`.
DensifyCounts prune_late(TrainState& state, const TrainOptions& options, const SplatScores& scores);

/// Resolves the options. Null where late pruning is off. `densify_until`: the last densification.
std::unique_ptr<Phase> make_late_pruning(TrainOptions& options, int densify_until);

}  // namespace fluxgs
