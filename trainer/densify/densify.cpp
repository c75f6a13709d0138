#include "trainer/densify/densify.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

namespace fluxgs {
namespace {

enum class Fate : std::uint8_t { keep, clone, split, prune };

float largest_scale(const PlanarFloats& p, std::size_t i) {
  return std::exp(std::max(
      {p.row(row::log_scale)[i], p.row(row::log_scale + 1)[i], p.row(row::log_scale + 2)[i]}));
}

float logit(double p) { return static_cast<float>(std::log(p / (1 - p))); }

/// Splats with a large mean gradient, the largest first if only `room` of them may grow.
std::vector<std::uint32_t> growing(const TrainState& state, const TrainOptions& options) {
  const float* sums = state.statistics.row(statistic::gradient_sum);
  const float* views = state.statistics.row(statistic::views);
  const auto mean = [&](std::uint32_t i) { return sums[i] / std::max(views[i], 1.0f); };
  std::vector<std::uint32_t> chosen;
  for (std::uint32_t i = 0; i < state.parameters.size(); ++i)
    if (mean(i) >= static_cast<float>(options.densify_gradient)) chosen.push_back(i);
  if (options.max_splats == 0) return chosen;

  const std::size_t size = state.parameters.size();
  const std::size_t room = options.max_splats > size ? options.max_splats - size : 0;
  if (chosen.size() > room) {
    std::ranges::stable_sort(chosen, [&](auto a, auto b) { return mean(a) > mean(b); });
    chosen.resize(room);
  }
  return chosen;
}

bool oversized(const TrainState& state, std::size_t i, const TrainOptions& options, double extent) {
  const double radius = static_cast<double>(state.statistics.row(statistic::radius)[i]);
  return (options.prune_screen_radius > 0 && radius > options.prune_screen_radius) ||
         static_cast<double>(largest_scale(state.parameters, i)) >
             options.prune_world_size * extent;
}

std::vector<Fate> decide(const TrainState& state, const TrainOptions& options, double extent) {
  const PlanarFloats& p = state.parameters;
  std::vector<Fate> fates(p.size(), Fate::keep);
  for (std::uint32_t i : growing(state, options))
    fates[i] = static_cast<double>(largest_scale(p, i)) > options.densify_size * extent
                   ? Fate::split
                   : Fate::clone;
  const float least = logit(std::max(options.prune_opacity, 1e-9));
  const bool limit_size =
      options.opacity_reset_interval > 0 && state.iteration > options.opacity_reset_interval;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (p.row(row::opacity)[i] < least || (limit_size && oversized(state, i, options, extent)))
      fates[i] = Fate::prune;
  return fates;
}

/// Turns a copy of a splat into one of the two that replace it: drawn from its own distribution
/// and smaller.
void scatter(PlanarFloats& p, std::size_t i, double shrink, Random& random) {
  glm::dvec3 offset;
  for (int c = 0; c < 3; ++c)
    offset[c] = normal(random) * std::exp(static_cast<double>(p.row(row::log_scale + c)[i]));
  const auto q = [&](int c) { return static_cast<double>(p.row(row::rotation + c)[i]); };
  const glm::dquat rotation(q(0), q(1), q(2), q(3));
  if (glm::length(rotation) > 0) offset = glm::normalize(rotation) * offset;
  for (int c = 0; c < 3; ++c) {
    p.row(row::position + c)[i] += static_cast<float>(offset[c]);
    p.row(row::log_scale + c)[i] -= static_cast<float>(std::log(shrink));
  }
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

DensifyCounts densify_and_prune(TrainState& state, const TrainOptions& options, double extent) {
  const std::vector<Fate> fates = decide(state, options, extent);
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

  state.parameters = state.parameters.gather(order);
  state.adam.first = state.adam.first.gather(moments);
  state.adam.second = state.adam.second.gather(moments);
  for (std::size_t i = old_count + copies.size(); i < order.size(); ++i)
    scatter(state.parameters, i, options.split_shrink, state.random);
  state.statistics = PlanarFloats(statistic::count, state.parameters.size());
  return counts;
}

void reset_opacity(TrainState& state, const TrainOptions& options) {
  const float limit = logit(options.opacity_reset_to);
  float* opacity = state.parameters.row(row::opacity);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) {
    opacity[i] = std::min(opacity[i], limit);
    state.adam.first.row(row::opacity)[i] = 0;
    state.adam.second.row(row::opacity)[i] = 0;
  }
}

}  // namespace fluxgs
