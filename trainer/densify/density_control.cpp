#include "trainer/densify/density_control.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/gtc/quaternion.hpp>

#include "fluxgs/math/logistic.h"
#include "trainer/core/indices.h"
#include "trainer/densify/camera_sampling.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/opacity_reset.h"

namespace fluxgs {
namespace {

float largest_scale(const PlanarFloats& p, std::size_t i) {
  return std::exp(std::max(
      {p.row(row::log_scale)[i], p.row(row::log_scale + 1)[i], p.row(row::log_scale + 2)[i]}));
}

/// Number of splats that may be added now. With a target, what goes is made up for.
std::size_t room(const TrainState& state, const TrainOptions& options, std::size_t pruned) {
  const auto& own = options.get<DensificationOptions>();
  const double size = static_cast<double>(state.parameters.size());
  double limit = 1e18;
  if (options.max_splats > 0) limit = static_cast<double>(options.max_splats) - size;
  if (own.growth > 0) limit = std::min(limit, own.growth * size);
  if (options.target_splats > 0) {
    // As many at each of the densifications that are left
    const int left = (own.until - state.iteration) / own.interval + 1;
    const double missing =
        static_cast<double>(options.target_splats) - size + static_cast<double>(pruned);
    limit = std::min(limit, missing / left);
  }
  return static_cast<std::size_t>(std::max(limit, 0.0));
}

/// The gradient from which on a splat may grow. What a new splat is worth is the share of the error
/// that it removes: the less error is left, the smaller the gradients that are worth one. Where the
/// removal of some has just cost much, smaller ones still are.
double least_gradient(const TrainState& state, const TrainOptions& options,
                      const SplatScores* scores) {
  // docs/method/experiments.md, "Growth by the loss", "Growth by worth"
  constexpr double kLossPower = 0.3, kMostLoss = 8, kMostWorth = 1.73;
  const auto& own = options.get<DensificationOptions>();
  if (options.target_splats > 0) return 0;
  double least = own.gradient;
  if (own.loss > 0 && scores)
    least *= std::pow(std::clamp(scores->loss / own.loss, 1 / kMostLoss, kMostLoss), kLossPower);
  if (own.worth > 0) least /= std::clamp(state.splat_worth / own.worth, 1.0, kMostWorth);
  return least;
}

/// The splats that stay and are to grow, the first by rank if there is room for some
/// only.
std::vector<std::uint32_t> select_for_growth(const TrainState& state, const TrainOptions& options,
                                             const SplatScores* scores,
                                             const std::vector<RefineAction>& actions) {
  const auto& own = options.get<DensificationOptions>();
  const auto& score = options.get<ScoreOptions>();
  const auto least = static_cast<float>(least_gradient(state, options, scores));
  const float quantile =
      scores ? score_quantile(scores->plus, *scores, score.quantile_plus, score.normalization)
             : 0.0f;
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < state.parameters.size(); ++i)
    if (actions[i] == RefineAction::keep && mean_gradient(state, i) >= least &&
        (!scores || scores->plus[i] > quantile))
      chosen.push_back(i);
  const auto pruned = static_cast<std::size_t>(std::ranges::count(actions, RefineAction::prune));
  const std::size_t most = room(state, options, pruned);
  if (chosen.size() <= most) return chosen;
  const auto rank = [&](std::uint32_t i) {
    if (!scores || own.growth_rank == GrowthRank::gradient) return mean_gradient(state, i);
    return score.normalization == ScoreNormalization::sum ? scores->plus[i]
                                                          : scores->plus[i] * scores->pixels[i];
  };
  std::ranges::stable_sort(chosen, [&](auto a, auto b) { return rank(a) > rank(b); });
  chosen.resize(most);
  return chosen;
}

bool oversized(const TrainState& state, std::size_t i, const DensificationOptions& own,
               double extent) {
  const double radius = static_cast<double>(state.statistics.row(statistic::radius)[i]);
  return (own.prune_screen_radius > 0 && radius > own.prune_screen_radius) ||
         (own.prune_world_size > 0 &&
          static_cast<double>(largest_scale(state.parameters, i)) > own.prune_world_size * extent);
}

/// Marks transparent and oversized splats.
void mark_pruned(const TrainState& state, const TrainOptions& options, double extent,
                 const SplatScores* scores, std::vector<RefineAction>& actions) {
  const auto& own = options.get<DensificationOptions>();
  const auto& score = options.get<ScoreOptions>();
  const int reset_interval = options.get<OpacityResetOptions>().interval;
  if (own.prune == Prune::none) return;
  const PlanarFloats& p = state.parameters;
  const auto least = static_cast<float>(logit(std::max(own.prune_opacity, 1e-9)));
  const bool moderate = own.prune == Prune::multiview && scores;
  const float quantile =
      moderate ? score_quantile(scores->minus, *scores, score.quantile_minus, score.normalization)
               : 0.0f;
  const bool limit_size = reset_interval > 0 && state.iteration > reset_interval;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool transparent =
        p.row(row::opacity)[i] < least && (!moderate || scores->minus[i] > quantile);
    if (transparent || (limit_size && oversized(state, i, own, extent)))
      actions[i] = RefineAction::prune;
  }
}

std::vector<RefineAction> decide(const TrainState& state, const TrainOptions& options,
                                 double extent, const SplatScores* scores) {
  const auto& own = options.get<DensificationOptions>();
  const PlanarFloats& p = state.parameters;
  std::vector<RefineAction> actions(p.size(), RefineAction::keep);
  mark_pruned(state, options, extent, scores, actions);
  const bool by_views = own.strategy == Densify::multiview;
  for (std::uint32_t i : select_for_growth(state, options, by_views ? scores : nullptr, actions))
    actions[i] = own.split == Split::long_axis ||
                         static_cast<double>(largest_scale(p, i)) > own.size * extent
                     ? RefineAction::split
                     : RefineAction::clone;
  return actions;
}

/// `offset` is along the splat's own axes, in scene units.
void move_in_own_frame(PlanarFloats& p, std::size_t i, glm::dvec3 offset) {
  const glm::dquat rotation = rotation_of(p, i);
  if (glm::length(rotation) > 0) offset = glm::normalize(rotation) * offset;
  for (int c = 0; c < 3; ++c) p.row(row::position + c)[i] += static_cast<float>(offset[c]);
}

/// Turns a copy of a splat into one of the two that replace it: drawn from its own distribution
/// and smaller.
void scatter(PlanarFloats& p, std::size_t i, double shrink, Random& random) {
  glm::dvec3 offset;
  for (int c = 0; c < 3; ++c)
    offset[c] = normal(random) * std::exp(static_cast<double>(p.row(row::log_scale + c)[i]));
  move_in_own_frame(p, i, offset);
  for (int c = 0; c < 3; ++c) p.row(row::log_scale + c)[i] -= static_cast<float>(std::log(shrink));
}

/// Turns a copy of a splat into one of two that lie side by side along its longest axis: half as
/// long, a little thinner, and of lower opacity, so that together they look like the one (Deng et
/// al. 2025, "Improving Densification in 3D Gaussian Splatting", long-axis split).
void shift_along_longest(PlanarFloats& p, std::size_t i, double side) {
  constexpr double kShift = 0.75, kLength = 0.5, kThickness = 0.85, kOpacity = 0.6;
  int longest = 0;
  for (int c = 1; c < 3; ++c)
    if (p.row(row::log_scale + c)[i] > p.row(row::log_scale + longest)[i]) longest = c;
  glm::dvec3 offset(0);
  offset[longest] =
      side * kShift * std::exp(static_cast<double>(p.row(row::log_scale + longest)[i]));
  move_in_own_frame(p, i, offset);
  for (int c = 0; c < 3; ++c)
    p.row(row::log_scale + c)[i] +=
        static_cast<float>(std::log(c == longest ? kLength : kThickness));
  const double opacity = sigmoid(static_cast<double>(p.row(row::opacity)[i]));
  p.row(row::opacity)[i] =
      static_cast<float>(logit(std::clamp(kOpacity * opacity, 1e-6, 1 - 1e-6)));
}

}  // namespace

float mean_gradient(const TrainState& state, std::size_t i) {
  return state.statistics.row(statistic::gradient_sum)[i] /
         std::max(state.statistics.row(statistic::views)[i], 1.0f);
}

void gather_statistics(TrainState& state, const Rasterizer& rasterizer, bool masked) {
  const std::vector<std::uint8_t>& visible = rasterizer.visible();
  const float* gradient = rasterizer.center_gradient();
  float* sums = state.statistics.row(statistic::gradient_sum);
  float* views = state.statistics.row(statistic::views);
  float* radius = state.statistics.row(statistic::radius);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) {
    if (!visible[i] || (masked && gradient[i] == 0)) continue;
    sums[i] += gradient[i];
    views[i] += 1;
    radius[i] = std::max(radius[i], rasterizer.screen_radius(i));
  }
}

DensifyCounts apply_refinement(TrainState& state, const TrainOptions& options,
                               const std::vector<RefineAction>& actions) {
  const auto& own = options.get<DensificationOptions>();
  DensifyCounts counts;
  // What stays keeps its place and its moments; what is new comes behind, with moments of zero.
  std::vector<std::uint32_t> order, halves;
  std::vector<std::uint32_t> copies;
  for (std::uint32_t i = 0; i < actions.size(); ++i) {
    if (actions[i] == RefineAction::keep || actions[i] == RefineAction::clone) order.push_back(i);
    if (actions[i] == RefineAction::clone) copies.push_back(i), ++counts.cloned;
    if (actions[i] == RefineAction::split) halves.insert(halves.end(), {i, i}), ++counts.split;
    if (actions[i] == RefineAction::prune) ++counts.pruned;
  }
  const std::size_t old_count = order.size();
  std::vector<std::uint32_t> moments = order;
  order.insert(order.end(), copies.begin(), copies.end());
  order.insert(order.end(), halves.begin(), halves.end());
  moments.resize(order.size(), PlanarFloats::kNew);

  rearrange(state, order, moments);
  for (std::size_t i = old_count + copies.size(), half = 0; i < order.size(); ++i, ++half) {
    if (own.split == Split::long_axis)
      shift_along_longest(state.parameters, i, half % 2 == 0 ? 1.0 : -1.0);
    else
      scatter(state.parameters, i, own.split_shrink, state.random);
  }
  return counts;
}

namespace {

void cap_opacity(TrainState& state, double cap) {
  if (cap >= 1) return;
  float* opacity = state.parameters.row(row::opacity);
  const auto limit = static_cast<float>(logit(cap));
  for (std::size_t i = 0; i < state.parameters.size(); ++i)
    opacity[i] = std::min(opacity[i], limit);
}

}  // namespace

DensifyCounts densify_and_prune(TrainState& state, const TrainOptions& options, double extent,
                                const SplatScores* scores) {
  const DensifyCounts counts =
      apply_refinement(state, options, decide(state, options, extent, scores));
  cap_opacity(state, options.get<DensificationOptions>().opacity_cap);
  return counts;
}

SplatScores sampled_scores(Training& t) {
  const auto& options = t.options.get<ScoreOptions>();
  const std::vector<std::uint32_t> sampled = sample_cameras(t.data.train, options, t.state.random);
  t.complete_colors();
  return score_splats(t.data.train, sampled, t.state.parameters, t.render_options(), options,
                      t.options.lambda_dssim, t.rasterizer, t.threads);
}

}  // namespace fluxgs
