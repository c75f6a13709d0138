#include "trainer/densify/densification.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trainer/core/profiler.h"
#include "trainer/densify/camera_sampling.h"
#include "trainer/densify/density_control.h"
#include "trainer/densify/late_pruning.h"
#include "trainer/densify/mcmc.h"
#include "trainer/densify/opacity_reset.h"

namespace fluxgs {
namespace {

class Densification final : public Phase {
 public:
  Densification(const DensificationOptions& options, int score_views)
      : options_(options), score_views_(score_views) {}

  const char* name() const override { return "densification"; }
  Period period() const override {
    return {.from = options_.from, .until = options_.until, .interval = options_.interval};
  }
  std::string effect() const override {
    return fmt::format("adds splats by {}{}",
                       kDensifyNames[static_cast<std::size_t>(options_.strategy)],
                       options_.strategy == Densify::mcmc   ? ", moves transparent ones"
                       : options_.prune == Prune::opacity   ? ", prunes transparent ones"
                       : options_.prune == Prune::multiview ? ", prunes by multi-view score"
                                                            : "");
  }
  PhaseWork work(int iteration, std::size_t) const override {
    if (!period().due(iteration)) return {};
    const bool scores =
        options_.strategy == Densify::multiview || options_.prune == Prune::multiview;
    return {.renders = scores ? 2.0 * score_views_ : 0.1, .growth = expected_growth()};
  }
  void after_backward(Training& t) override {
    if (options_.strategy != Densify::mcmc && t.state.iteration <= options_.until)
      gather_statistics(t.state, t.rasterizer, !t.view->used.pixels.empty());
  }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (!period().due(t.state.iteration)) return {};
    TrainOptions options = t.options;
    options.max_splats = t.max_splats();
    if (options_.strategy == Densify::mcmc) {
      relocate_and_grow(t.state, options);
    } else if (options_.strategy == Densify::multiview || options_.prune == Prune::multiview) {
      const SplatScores scores = sampled_scores(t);
      densify_and_prune(t.state, options, t.extent, &scores);
    } else {
      densify_and_prune(t.state, options, t.extent, nullptr);
    }
    return {};
  }

 private:
  double expected_growth() const {
    if (options_.strategy == Densify::mcmc) return std::log1p(options_.mcmc_growth);
    // Most of what may be added is, and some splats are pruned
    return options_.growth > 0 ? 0.9 * std::log1p(options_.growth) : 0.4;
  }

  DensificationOptions options_;
  int score_views_;
};

class PositionNoise final : public Phase {
 public:
  explicit PositionNoise(int iterations) : iterations_(iterations) {}
  const char* name() const override { return "position noise"; }
  Period period() const override { return {.from = 1, .until = iterations_}; }
  std::string effect() const override { return "moves low-opacity splats at random (MCMC)"; }
  std::optional<PhaseReport> after_step(Training& t) override {
    add_noise(t.state, t.options.get<DensificationOptions>(), t.position_lr(), t.threads);
    return {};
  }

 private:
  int iterations_;
};

}  // namespace

OptionFields DensificationOptions::fields(const TrainOptions& all) {
  const bool mcmc = strategy == Densify::mcmc, multiview = strategy == Densify::multiview;
  const bool limited =
      growth > 0 || all.max_splats > 0 || all.target_splats > 0 || all.max_memory > 0;
  const bool prunes = prune != Prune::none;
  const bool late_pruning = all.get<LatePruningOptions>().mode != LatePrune::off;
  const char* by_gradients = "--densify gradient or multiview";
  const char* random_split = "--densify gradient or multiview with --split random";
  const char* after_resets =
      "--prune multiview or opacity with an --opacity-reset-interval below --densify-until";
  return {
      choice("densify", "strategy: multiview (gradients and errors), gradient or mcmc", strategy,
             kDensifyNames),

      whole("densify-from", "first iteration at which splats are added", from, 0, kUnlimited),
      whole("densify-until",
            "last iteration at which splats are added (0: half of the iterations, at most "
            "15000)",
            until, 0, kUnlimited),
      whole("densify-interval",
            "iterations between densifications (0: a hundredth of them, at least 50)", interval, 0,
            kUnlimited),
      real("densify-gradient", "screen-space gradient above which a splat is cloned or split",
           gradient, 0, kUnlimited)
          .only_if(!mcmc && all.target_splats == 0,
                   "--densify gradient or multiview without --target-splats"),
      real(
          "densify-loss",
          "loss (root mean square of pixels) at which --densify-gradient holds; the better a scene "
          "matches its images, the smaller gradients suffice (0: the same at any loss)",
          loss, 0, 1)
          .only_if(multiview && all.target_splats == 0,
                   "--densify multiview without --target-splats"),
      real("densify-worth",
           "dB; smaller gradients suffice where late pruning lost more PSNR for its share of the "
           "splats (its logarithm; 0: never)",
           worth, 0, 1000)
          .only_if(!mcmc && all.target_splats == 0 && late_pruning,
                   "--late-prune and --densify gradient or multiview without --target-splats"),
      real("densify-size", "size that separates cloning from splitting, x scene extent", size, 0,
           kUnlimited)
          .only_if(!mcmc && split == Split::random, random_split),
      choice("split", "way to split a large splat", split, kSplitNames)
          .only_if(!mcmc, by_gradients),
      real("split-shrink", "divisor of the scales of a split splat", split_shrink, 1, 100)
          .only_if(!mcmc && split == Split::random, random_split),
      real("densify-growth",
           "maximum number of splats added at once, x the splats there are (0: no maximum)", growth,
           0, kUnlimited)
          .only_if(!mcmc, by_gradients),
      choice("growth-rank", "order of the splats that may grow, where there is room for some",
             growth_rank, kGrowthRankNames)
          .only_if(multiview && limited,
                   "--densify multiview with --densify-growth or another limit"),
      choice("prune", "choice of the splats that are removed at densifications", prune, kPruneNames)
          .only_if(!mcmc, by_gradients),
      real("prune-opacity", "splats of lower opacity are removed (mcmc: moved)", prune_opacity, 0,
           1)
          .only_if(mcmc || prunes, "--prune multiview or opacity"),
      real("prune-screen-radius",
           "px; larger splats are removed after the first opacity reset (0: never)",
           prune_screen_radius, 0, kUnlimited)
          .only_if(resets_opacity(all) && prunes, after_resets),
      real("prune-world-size",
           "x scene extent; larger splats are removed after the first opacity reset (0: never)",
           prune_world_size, 0, kUnlimited)
          .only_if(resets_opacity(all) && prunes, after_resets),
      real("opacity-cap", "maximum opacity after a densification", opacity_cap, 0.01, 1)
          .only_if(!mcmc, by_gradients),
      real("mcmc-growth", "splats added at each densification, x the splats there are", mcmc_growth,
           0, 10)
          .only_if(mcmc, "--densify mcmc"),
      real("mcmc-noise", "noise of positions, x their learning rate", mcmc_noise, 0, 1e12)
          .only_if(mcmc, "--densify mcmc")};
}

std::unique_ptr<Phase> make_densification(TrainOptions& options) {
  auto& own = options.get<DensificationOptions>();
  resolve(own.until, std::min(options.iterations / 2, 15000));
  resolve(own.interval, std::max(options.iterations / 100, 50));
  auto& scores = options.get<ScoreOptions>();
  scores.uses_plus |= own.strategy == Densify::multiview;
  scores.uses_minus |= own.strategy != Densify::mcmc && own.prune == Prune::multiview;
  return std::make_unique<Densification>(own, scores.views);
}

std::unique_ptr<Phase> make_position_noise(TrainOptions& options) {
  if (options.get<DensificationOptions>().strategy != Densify::mcmc) return nullptr;
  return std::make_unique<PositionNoise>(options.iterations);
}

}  // namespace fluxgs
