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
  state.parameters = state.parameters.gather(order);
  state.adam.first = state.adam.first.gather(moments);
  state.adam.second = state.adam.second.gather(moments);
  for (auto& [name, attached] : state.attached)
    attached.values = attached.values.gather(attached.moments ? moments : order);
  if (!state.degrees.empty()) state.degrees = gather(state.degrees, order);
  state.statistics = PlanarFloats(statistic::count, order.size());
}

void clear_moments(TrainState& state, std::size_t i) {
  const auto clear = [i](PlanarFloats& rows) {
    for (int r = 0; r < rows.rows(); ++r) rows.row(r)[i] = 0;
  };
  clear(state.adam.first);
  clear(state.adam.second);
  for (auto& [name, attached] : state.attached)
    if (attached.moments) clear(attached.values);
}

}  // namespace fluxgs
