#include "trainer/state/train_state.h"

namespace fluxgs {

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
  if (!state.degrees.empty()) {
    std::vector<std::uint8_t> degrees(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) degrees[i] = state.degrees[order[i]];
    state.degrees = std::move(degrees);
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
