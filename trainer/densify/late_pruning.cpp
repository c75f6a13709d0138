#include "trainer/densify/late_pruning.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "fluxgs/math/logistic.h"
#include "trainer/core/indices.h"
#include "trainer/data/dataset.h"
#include "trainer/densify/density_control.h"
#include "trainer/model/view_budget.h"
#include "trainer/raster/blend_weights.h"

namespace fluxgs {
namespace {

constexpr double kContributionRenders = 1.5;  // for the contributions of a view

/// Indices by contribution for their cost, the least first; ties by index. A splat costs its place
/// in the file and the pixels that it has drawn: half of the cost of all splats is for the one,
/// half for the other. Without those that only other views may see.
std::vector<std::uint32_t> by_contribution_per_cost(const SplatScores& scores) {
  const double pixels = std::accumulate(scores.pixels.begin(), scores.pixels.end(), 0.0);
  const double mean = pixels / static_cast<double>(scores.pixels.size());
  std::vector<double> worth(scores.pixels.size());
  for (std::size_t i = 0; i < worth.size(); ++i)
    worth[i] = double{scores.contribution[i]} / std::max(mean + double{scores.pixels[i]}, 1.0);
  std::vector<std::uint32_t> order = all_indices(worth.size());
  if (scores.sampled) std::erase_if(order, [&](auto i) { return scores.pixels[i] == 0; });
  std::ranges::stable_sort(order, [&](auto a, auto b) { return worth[a] < worth[b]; });
  return order;
}

/// Contributions and pixels over so many training views, others each time; the other scores are
/// left out.
SplatScores contributions(const Training& t, std::size_t views, double turn) {
  SplatScores scores;
  scores.contribution.resize(t.state.parameters.size());
  scores.pixels.resize(t.state.parameters.size());
  const auto add = [](std::vector<float>& sums, const std::vector<float>& more) {
    std::ranges::transform(sums, more, sums.begin(), std::plus<>());
  };
  BlendWeights weights(t.state.parameters, t.render_options(), t.threads);
  const std::vector<std::uint32_t> chosen = spread_indices(t.data.train.size(), views, turn);
  scores.sampled = chosen.size() < t.data.train.size();
  ProgressCounter counter(t.progress, chosen.size());
  for (const std::uint32_t index : chosen) {
    const View& view = t.data.train[index];
    add(scores.contribution, weights.of(view.camera, view.used));
    add(scores.pixels, weights.pixels());
    counter.add_one();
  }
  return scores;
}

class LatePruning final : public Phase {
 public:
  explicit LatePruning(const LatePruningOptions& options) : options_(options) {}

  const char* name() const override { return "late pruning"; }
  Period period() const override {
    return {.from = options_.from, .until = options_.until, .interval = options_.interval};
  }
  std::string effect() const override {
    return options_.mode == LatePrune::contribution
               ? fmt::format("removes the splats with the least {:g}% of all alpha x T",
                             100 * options_.share)
               : fmt::format("removes splats of opacity below {:g}", options_.opacity);
  }
  bool reports(int iteration) const override { return period().due(iteration); }
  PhaseWork work(int iteration, std::size_t views) const override {
    if (!reports(iteration)) return {};
    const double seen = options_.mode == LatePrune::contribution
                            ? static_cast<double>(std::min(views, sampled_views()))
                            : 6;
    return {.renders = kContributionRenders * seen, .growth = -0.05};
  }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (!period().due(t.state.iteration)) return {};
    const auto scores = [&] {
      if (options_.mode == LatePrune::opacity) return sampled_scores(t);
      const int event = (t.state.iteration - options_.from) / std::max(options_.interval, 1);
      const double turn = event * std::numbers::phi;  // turns of the golden ratio are well spread
      return contributions(t, sampled_views(), turn - std::floor(turn));
    };
    prune_late(t.state, t.options, scores());
    return PhaseReport();
  }

 private:
  std::size_t sampled_views() const { return static_cast<std::size_t>(options_.views); }

  LatePruningOptions options_;
};

}  // namespace

OptionFields LatePruningOptions::fields(const TrainOptions&) {
  const bool on = mode != LatePrune::off;
  const char* any = "--late-prune opacity or contribution";
  return {
      choice("late-prune", "choice of the splats that are removed now and then", mode,
             kLatePruneNames),
      whole("late-prune-from",
            "first iteration of late pruning (0: a fifth of the iterations; by opacity: an "
            "interval after the last densification)",
            from, 0, kUnlimited)
          .only_if(on, any),
      whole("late-prune-interval",
            "iterations between late prunings (0: a tenth of the iterations)", interval, 0,
            kUnlimited)
          .only_if(on, any),
      whole("late-prune-until",
            "last iteration of late pruning (0: 2/3 of the iterations; by opacity: 9/10)", until, 0,
            kUnlimited)
          .only_if(on, any),
      real("late-prune-opacity", "late pruning by opacity removes splats below this", opacity, 0, 1)
          .only_if(mode == LatePrune::opacity, "--late-prune opacity"),
      real("late-prune-share", "late pruning by contribution removes this share of all alpha x T",
           share, 0, 1)
          .only_if(mode == LatePrune::contribution, "--late-prune contribution"),
      whole("late-prune-views",
            "views that contributions are sampled from (0: a hundredth of the iterations, at least "
            "40)",
            views, 0, kUnlimited)
          .only_if(mode == LatePrune::contribution, "--late-prune contribution")};
}

DensifyCounts prune_late(TrainState& state, const TrainOptions& options,
                         const SplatScores& scores) {
  const auto& own = options.get<LatePruningOptions>();
  const std::size_t size = state.parameters.size();
  std::vector<RefineAction> actions(size, RefineAction::keep);
  std::size_t left = size > options.target_splats ? size - options.target_splats : 0;
  if (own.mode == LatePrune::opacity) {
    const auto& score = options.get<ScoreOptions>();
    const auto least = static_cast<float>(logit(std::max(own.opacity, 1e-9)));
    // No pixel has these, so that they have no score either
    const auto undrawn = static_cast<float>(logit(std::max(options.render.alpha_min, 1e-9)));
    const float quantile =
        score_quantile(scores.minus, scores, score.quantile_minus, score.normalization);
    for (std::size_t i = 0; i < size && left > 0; ++i) {
      const float opacity_logit = state.parameters.row(row::opacity)[i];
      if (opacity_logit < least && (opacity_logit < undrawn || scores.minus[i] > quantile))
        actions[i] = RefineAction::prune, --left;
    }
  } else if (own.mode == LatePrune::contribution) {
    double total = 0;
    for (float c : scores.contribution) total += static_cast<double>(c);
    double rest = total * own.share;
    for (std::uint32_t i : by_contribution_per_cost(scores)) {
      rest -= static_cast<double>(scores.contribution[i]);
      if (rest < 0 || left == 0) break;
      actions[i] = RefineAction::prune, --left;
    }
  }
  return apply_refinement(state, options, actions);
}

std::unique_ptr<Phase> make_late_pruning(TrainOptions& options, int densify_until) {
  auto& own = options.get<LatePruningOptions>();
  if (own.mode == LatePrune::off) return nullptr;
  const int n = options.iterations;
  const bool by_opacity = own.mode == LatePrune::opacity;
  resolve(own.interval, n / 10);
  resolve(own.from, by_opacity ? densify_until + own.interval : n / 5);
  resolve(own.until, by_opacity ? n / 10 * 9 : n / 3 * 2);
  const int events = std::max(own.until - own.from, 0) / own.interval + 1;
  resolve(own.views, static_cast<int>(affordable_views(n, events * kContributionRenders)));
  if (by_opacity) options.get<ScoreOptions>().uses_minus = true;
  return std::make_unique<LatePruning>(own);
}

}  // namespace fluxgs
