#include "trainer/state/train_state.h"

namespace fluxgs {
namespace {

/// `columns` entries a splat.
template <class T>
std::vector<T> gather(const std::vector<T>& from, const std::vector<std::uint32_t>& order,
                      std::size_t columns = 1) {
  std::vector<T> result;
  result.reserve(columns * order.size());
  for (const std::uint32_t i : order) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(i * columns);
    result.insert(result.end(), first, first + static_cast<std::ptrdiff_t>(columns));
  }
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
    state.rounding->weights = gather(state.rounding->weights, order);
    state.rounding->sh_factors =
        gather(state.rounding->sh_factors, order, sh_factor_size(sh_degree_of(state.parameters)));
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
