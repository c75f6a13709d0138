#include "trainer/model/train_state.h"

namespace fluxgs {
namespace {

std::vector<std::uint8_t> gather(const std::vector<std::uint8_t>& from,
                                 const std::vector<std::uint32_t>& order) {
  std::vector<std::uint8_t> result;
  result.reserve(order.size());
  for (const std::uint32_t i : order) result.push_back(from[i]);
  return result;
}

}  // namespace

void rearrange(TrainState& state, const std::vector<std::uint32_t>& order,
               const std::vector<std::uint32_t>& moments) {
  const auto gather_moments = [&](AdamState& adam) {
    adam.first = adam.first.gather(moments);
    adam.second = adam.second.gather(moments);
  };
  state.parameters = state.parameters.gather(order);
  gather_moments(state.adam);
  if (state.networks) {
    state.networks->latents = state.networks->latents.gather(order);
    gather_moments(state.networks->adam);
  }
  if (!state.degrees.empty()) state.degrees = gather(state.degrees, order);
  if (state.rounding) {
    const int degree = sh_degree_of(state.parameters);
    state.rounding->costs = costs_of(state.rounding->costs, degree, order, degree);
    if (state.rounding->offsets.size() > 0)
      state.rounding->offsets = state.rounding->offsets.gather(order);
  }
  state.statistics = PlanarFloats(statistic::count, order.size());
}

void clear_moments(TrainState& state, std::size_t i) {
  const auto clear = [i](PlanarFloats& rows) {
    for (int r = 0; r < rows.rows(); ++r) rows.row(r)[i] = 0;
  };
  clear(state.adam.first);
  clear(state.adam.second);
  if (!state.networks) return;
  clear(state.networks->adam.first);
  clear(state.networks->adam.second);
}

}  // namespace fluxgs
