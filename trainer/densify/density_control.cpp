#include "trainer/densify/density_control.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/gtc/quaternion.hpp>

#include "trainer/core/indices.h"
#include "trainer/core/logistic.h"

namespace fluxgs {
namespace {

enum class Fate : std::uint8_t { keep, clone, split, prune };

float largest_scale(const PlanarFloats& p, std::size_t i) {
  return std::exp(std::max(
      {p.row(row::log_scale)[i], p.row(row::log_scale + 1)[i], p.row(row::log_scale + 2)[i]}));
}

/// Mean gradient of splat i since the last densification.
float mean_gradient(const TrainState& state, std::uint32_t i) {
  return state.statistics.row(statistic::gradient_sum)[i] /
         std::max(state.statistics.row(statistic::views)[i], 1.0f);
}

/// How many splats may be added now. With a target, what goes is made up for.
std::size_t room(const TrainState& state, const TrainOptions& options, std::size_t pruned) {
  const double size = static_cast<double>(state.parameters.size());
  double limit = 1e18;
  if (options.max_splats > 0) limit = static_cast<double>(options.max_splats) - size;
  if (options.densify_growth > 0) limit = std::min(limit, options.densify_growth * size);
  if (options.target_splats > 0) {
    // As many at each of the densifications that are left
    const int left = (options.densify_until - state.iteration) / options.densify_interval + 1;
    const double missing =
        static_cast<double>(options.target_splats) - size + static_cast<double>(pruned);
    limit = std::min(limit, missing / left);
  }
  return static_cast<std::size_t>(std::max(limit, 0.0));
}

/// Of the splats that stay those that are to grow, the first by rank if there is room for some
/// only.
std::vector<std::uint32_t> growing(const TrainState& state, const TrainOptions& options,
                                   const SplatScores* scores, const std::vector<Fate>& fates) {
  const float least =
      options.target_splats > 0 ? 0.0f : static_cast<float>(options.densify_gradient);
  const float quantile =
      scores ? score_quantile(scores->plus, *scores, options.quantile_plus, options.score_share)
             : 0.0f;
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < state.parameters.size(); ++i)
    if (fates[i] == Fate::keep && mean_gradient(state, i) >= least &&
        (!scores || scores->plus[i] > quantile))
      chosen.push_back(i);
  const auto pruned = static_cast<std::size_t>(std::ranges::count(fates, Fate::prune));
  const std::size_t most = room(state, options, pruned);
  if (chosen.size() <= most) return chosen;
  const auto rank = [&](std::uint32_t i) {
    if (!scores || options.growth_rank == GrowthRank::gradient) return mean_gradient(state, i);
    return options.score_share == ScoreShare::sum ? scores->plus[i]
                                                  : scores->plus[i] * scores->pixels[i];
  };
  std::ranges::stable_sort(chosen, [&](auto a, auto b) { return rank(a) > rank(b); });
  chosen.resize(most);
  return chosen;
}

bool oversized(const TrainState& state, std::size_t i, const TrainOptions& options, double extent) {
  const double radius = static_cast<double>(state.statistics.row(statistic::radius)[i]);
  return (options.prune_screen_radius > 0 && radius > options.prune_screen_radius) ||
         (options.prune_world_size > 0 && static_cast<double>(largest_scale(state.parameters, i)) >
                                              options.prune_world_size * extent);
}

/// Marks transparent and oversized splats.
void mark_pruned(const TrainState& state, const TrainOptions& options, double extent,
                 const SplatScores* scores, std::vector<Fate>& fates) {
  if (options.prune == Prune::none) return;
  const PlanarFloats& p = state.parameters;
  const auto least = static_cast<float>(logit(std::max(options.prune_opacity, 1e-9)));
  const bool moderate = options.prune == Prune::multiview && scores;
  const float quantile =
      moderate ? score_quantile(scores->minus, *scores, options.quantile_minus, options.score_share)
               : 0.0f;
  const bool limit_size =
      options.opacity_reset_interval > 0 && state.iteration > options.opacity_reset_interval;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool faint = p.row(row::opacity)[i] < least && (!moderate || scores->minus[i] > quantile);
    if (faint || (limit_size && oversized(state, i, options, extent))) fates[i] = Fate::prune;
  }
}

std::vector<Fate> decide(const TrainState& state, const TrainOptions& options, double extent,
                         const SplatScores* scores) {
  const PlanarFloats& p = state.parameters;
  std::vector<Fate> fates(p.size(), Fate::keep);
  mark_pruned(state, options, extent, scores, fates);
  const bool by_views = options.densify == Densify::multiview;
  for (std::uint32_t i : growing(state, options, by_views ? scores : nullptr, fates))
    fates[i] = options.split == Split::long_axis ||
                       static_cast<double>(largest_scale(p, i)) > options.densify_size * extent
                   ? Fate::split
                   : Fate::clone;
  return fates;
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
/// long, a little thinner, and fainter, so that together they look like the one (Deng et al. 2025,
/// "Improving Densification in 3D Gaussian Splatting", long-axis split).
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

void gather_statistics(TrainState& state, const Rasterizer& rasterizer) {
  const std::vector<std::uint8_t>& visible = rasterizer.visible();
  const float* gradient = rasterizer.center_gradient();
  float* sums = state.statistics.row(statistic::gradient_sum);
  float* views = state.statistics.row(statistic::views);
  float* radius = state.statistics.row(statistic::radius);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) {
    if (!visible[i]) continue;
    sums[i] += gradient[i];
    views[i] += 1;
    radius[i] = std::max(radius[i], rasterizer.screen_radius(i));
  }
}

namespace {

DensifyCounts carry_out(TrainState& state, const TrainOptions& options,
                        const std::vector<Fate>& fates) {
  DensifyCounts counts;
  // What stays keeps its place and its moments; what is new comes behind, with moments of zero.
  std::vector<std::uint32_t> order, halves;
  std::vector<std::uint32_t> copies;
  for (std::uint32_t i = 0; i < fates.size(); ++i) {
    if (fates[i] == Fate::keep || fates[i] == Fate::clone) order.push_back(i);
    if (fates[i] == Fate::clone) copies.push_back(i), ++counts.cloned;
    if (fates[i] == Fate::split) halves.insert(halves.end(), {i, i}), ++counts.split;
    if (fates[i] == Fate::prune) ++counts.pruned;
  }
  const std::size_t old_count = order.size();
  std::vector<std::uint32_t> moments = order;
  order.insert(order.end(), copies.begin(), copies.end());
  order.insert(order.end(), halves.begin(), halves.end());
  moments.resize(order.size(), PlanarFloats::kNew);

  rearrange(state, order, moments);
  for (std::size_t i = old_count + copies.size(), half = 0; i < order.size(); ++i, ++half) {
    if (options.split == Split::long_axis)
      shift_along_longest(state.parameters, i, half % 2 == 0 ? 1.0 : -1.0);
    else
      scatter(state.parameters, i, options.split_shrink, state.random);
  }
  return counts;
}

void cap_opacity(TrainState& state, double cap) {
  if (cap >= 1) return;
  float* opacity = state.parameters.row(row::opacity);
  const auto limit = static_cast<float>(logit(cap));
  for (std::size_t i = 0; i < state.parameters.size(); ++i)
    opacity[i] = std::min(opacity[i], limit);
}

/// Indices by what splats contribute for what they cost, the least first; ties by index. A splat
/// costs its place in the file and the pixels that it has drawn: half of the cost of all splats is
/// for the one, half for the other.
std::vector<std::uint32_t> by_worth(const SplatScores& scores) {
  const double pixels = std::accumulate(scores.pixels.begin(), scores.pixels.end(), 0.0);
  const double mean = pixels / static_cast<double>(scores.pixels.size());
  std::vector<double> worth(scores.pixels.size());
  for (std::size_t i = 0; i < worth.size(); ++i)
    worth[i] = double{scores.contribution[i]} / std::max(mean + double{scores.pixels[i]}, 1.0);
  std::vector<std::uint32_t> order = all_indices(worth.size());
  std::ranges::stable_sort(order, [&](auto a, auto b) { return worth[a] < worth[b]; });
  return order;
}

}  // namespace

DensifyCounts densify_and_prune(TrainState& state, const TrainOptions& options, double extent,
                                const SplatScores* scores) {
  const DensifyCounts counts = carry_out(state, options, decide(state, options, extent, scores));
  cap_opacity(state, options.opacity_cap);
  return counts;
}

DensifyCounts prune_late(TrainState& state, const TrainOptions& options,
                         const SplatScores& scores) {
  const std::size_t size = state.parameters.size();
  std::vector<Fate> fates(size, Fate::keep);
  std::size_t left = size > options.target_splats ? size - options.target_splats : 0;
  if (options.late_prune == LatePrune::opacity) {
    const auto least = static_cast<float>(logit(std::max(options.late_prune_opacity, 1e-9)));
    // No pixel has these, so that they have no score either
    const auto undrawn = static_cast<float>(logit(std::max(options.render.alpha_min, 1e-9)));
    const float quantile =
        score_quantile(scores.minus, scores, options.quantile_minus, options.score_share);
    for (std::size_t i = 0; i < size && left > 0; ++i) {
      const float opacity = state.parameters.row(row::opacity)[i];
      if (opacity < least && (opacity < undrawn || scores.minus[i] > quantile))
        fates[i] = Fate::prune, --left;
    }
  } else if (options.late_prune == LatePrune::contribution) {
    double total = 0;
    for (float c : scores.contribution) total += static_cast<double>(c);
    double rest = total * options.late_prune_share;
    for (std::uint32_t i : by_worth(scores)) {
      rest -= static_cast<double>(scores.contribution[i]);
      if (rest < 0 || left == 0) break;
      fates[i] = Fate::prune, --left;
    }
  }
  return carry_out(state, options, fates);
}

void reset_opacity(TrainState& state, const TrainOptions& options) {
  const auto limit = static_cast<float>(logit(options.opacity_reset_to));
  float* opacity = state.parameters.row(row::opacity);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) {
    opacity[i] = std::min(opacity[i], limit);
    state.adam.first.row(row::opacity)[i] = 0;
    state.adam.second.row(row::opacity)[i] = 0;
  }
}

}  // namespace fluxgs
