#include "trainer/densify/mcmc.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "fluxgs/math/logistic.h"
#include "trainer/core/indices.h"

namespace fluxgs {
namespace {

constexpr std::size_t kNoisePiece = 1024;  // splats
constexpr int kMaxCopies = 51;             // in one place; as the first release of the method does

double opacity_of(const PlanarFloats& p, std::size_t i) {
  return sigmoid(static_cast<double>(p.row(row::opacity)[i]));
}

/// Draws among `from` in proportion to opacity.
std::vector<std::uint32_t> draw(const PlanarFloats& p, const std::vector<std::uint32_t>& from,
                                std::size_t count, Random& random) {
  std::vector<double> sums(from.size());
  double total = 0;
  for (std::size_t k = 0; k < from.size(); ++k) sums[k] = total += opacity_of(p, from[k]);
  std::vector<std::uint32_t> drawn(count);
  for (std::uint32_t& d : drawn) {
    const auto at = std::ranges::upper_bound(sums, uniform(random) * total);
    d = from[static_cast<std::size_t>(std::min(at, sums.end() - 1) - sums.begin())];
  }
  return drawn;
}

/// Makes splat i one of `copies` in its place.
void share(PlanarFloats& p, std::size_t i, int copies, const DensificationOptions& options) {
  const Shared s = shared_among(opacity_of(p, i), copies);
  p.row(row::opacity)[i] = static_cast<float>(
      logit(std::clamp(s.opacity, std::max(options.prune_opacity, 1e-6), 1 - 1e-6)));
  for (int c = 0; c < 3; ++c) p.row(row::log_scale + c)[i] += static_cast<float>(std::log(s.scale));
}

/// Divides every drawn splat among itself and its copies.
void share_all(TrainState& state, const std::vector<std::uint32_t>& drawn,
               const DensificationOptions& options) {
  std::vector<int> copies(state.parameters.size(), 1);
  for (std::uint32_t d : drawn) ++copies[d];
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (copies[i] == 1) continue;
    share(state.parameters, i, std::min(copies[i], kMaxCopies), options);
    clear_moments(state, i);
  }
}

/// Returns the number of splats that moved.
std::size_t relocate(TrainState& state, const DensificationOptions& options) {
  std::vector<std::uint32_t> dead, alive;
  for (std::uint32_t i = 0; i < state.parameters.size(); ++i)
    (opacity_of(state.parameters, i) <= options.prune_opacity ? dead : alive).push_back(i);
  if (alive.empty() || dead.empty()) return 0;
  const auto drawn = draw(state.parameters, alive, dead.size(), state.random);
  share_all(state, drawn, options);
  std::vector<std::uint32_t> order = all_indices(state.parameters.size()), moments = order;
  for (std::size_t k = 0; k < dead.size(); ++k) {
    order[dead[k]] = drawn[k];
    moments[dead[k]] = PlanarFloats::kNew;
  }
  rearrange(state, order, moments);
  return dead.size();
}

/// Returns the number of splats that were added.
std::size_t grow(TrainState& state, const TrainOptions& options) {
  const auto& own = options.get<DensificationOptions>();
  const std::size_t size = state.parameters.size();
  auto count = static_cast<std::uint64_t>((1 + own.mcmc_growth) * static_cast<double>(size));
  for (const std::uint64_t limit : {options.target_splats, options.max_splats})
    if (limit > 0) count = std::min(count, limit);
  if (count <= size) return 0;
  std::vector<std::uint32_t> order = all_indices(state.parameters.size()), moments = order;
  const auto drawn = draw(state.parameters, order, count - size, state.random);
  share_all(state, drawn, own);
  order.insert(order.end(), drawn.begin(), drawn.end());
  moments.resize(order.size(), PlanarFloats::kNew);
  rearrange(state, order, moments);
  return count - size;
}

}  // namespace

Shared shared_among(double opacity, int copies) {
  const double each = 1 - std::pow(1 - opacity, 1.0 / copies);
  double denominator = 0;
  for (int i = 1; i <= copies; ++i) {
    double binomial = 1, power = each;  // C(i−1, k) and oᵏ⁺¹
    for (int k = 0; k < i; ++k) {
      denominator += binomial * (k % 2 == 0 ? power : -power) / std::sqrt(k + 1.0);
      binomial *= static_cast<double>(i - 1 - k) / (k + 1);
      power *= each;
    }
  }
  return {each, opacity / denominator};
}

DensifyCounts relocate_and_grow(TrainState& state, const TrainOptions& options) {
  DensifyCounts counts;
  counts.pruned = relocate(state, options.get<DensificationOptions>());
  counts.cloned = grow(state, options);
  return counts;
}

void add_noise(TrainState& state, const DensificationOptions& options, double rate,
               const Threads& threads) {
  constexpr double kSteepness = 100;
  PlanarFloats& p = state.parameters;
  const std::uint64_t seed = state.random();
  threads.for_pieces(p.size(), kNoisePiece, [&](std::size_t begin, std::size_t end) {
    Random random(seed + begin);
    for (std::size_t i = begin; i < end; ++i) {
      const double amount = sigmoid(kSteepness * (options.prune_opacity - opacity_of(p, i)));
      if (amount < 1e-6) continue;
      glm::dvec3 noise(normal(random), normal(random), normal(random));
      const glm::dquat raw = rotation_of(p, i);
      if (!(glm::length(raw) > 0)) continue;
      const glm::dquat rotation = glm::normalize(raw);
      noise = glm::conjugate(rotation) * noise;
      for (int c = 0; c < 3; ++c)  // Σ = R·S²·Rᵀ
        noise[c] *= std::exp(2 * static_cast<double>(p.row(row::log_scale + c)[i]));
      noise = rotation * noise * (amount * rate * options.mcmc_noise);
      for (int c = 0; c < 3; ++c) p.row(row::position + c)[i] += static_cast<float>(noise[c]);
    }
  });
}

}  // namespace fluxgs
