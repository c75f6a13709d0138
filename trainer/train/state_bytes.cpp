#include "trainer/train/state_bytes.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <span>
#include <utility>

namespace fluxgs {
namespace {

void append_floats(std::vector<std::byte>& out, std::span<const float> floats) {
  const auto bytes = std::as_bytes(floats);
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void append_rows(std::vector<std::byte>& out, const PlanarFloats& planes) {
  for (int r = 0; r < planes.rows(); ++r) append_floats(out, {planes.row(r), planes.size()});
}

const std::byte* take_rows(const std::byte* in, PlanarFloats& planes) {
  const std::size_t bytes = planes.size() * sizeof(float);
  for (int r = 0; r < planes.rows(); ++r, in += bytes)
    if (bytes > 0) std::memcpy(planes.row(r), in, bytes);
  return in;
}

const std::byte* take_floats(const std::byte* in, std::size_t count, std::vector<float>& floats) {
  floats.resize(count);
  if (count > 0) std::memcpy(floats.data(), in, count * sizeof(float));
  return in + count * sizeof(float);
}

const std::byte* take_costs(const std::byte* in, const StateLayout& layout, ErrorCosts& costs) {
  in = take_floats(in, layout.splats, costs.weights);
  in = take_floats(in, layout.splats * sh_factor_size(layout.sh_degree), costs.sh_factors);
  in = take_floats(in, layout.splats * kTriangle3, costs.scale);
  return take_floats(in, layout.splats * kTriangle3, costs.rotation);
}

}  // namespace

std::size_t StateLayout::model_floats() const {
  return networks() ? appearance_floats(psi, phi) : 0;
}

std::optional<std::uint64_t> StateLayout::size() const {
  if (splats > (std::uint64_t{1} << 40)) return {};
  const int rows = 3 * row::count(sh_degree) + statistic::count +
                   (networks() ? 3 * networks::kShColumns : 0) +
                   (rounding ? row::count(sh_degree) : 0);
  const std::uint64_t floats =
      static_cast<std::uint64_t>(rows) + (rounding ? error_costs_size(sh_degree) : 0);
  return splats * (floats * sizeof(float) + (own_degrees ? 1 : 0)) + model_floats() * sizeof(float);
}

StateLayout layout_of(const TrainState& state) {
  const auto& n = state.networks;
  return {state.parameters.size(), sh_degree_of(state.parameters),
          !state.degrees.empty(),  n && n->model.psi,
          n && n->model.phi,       state.rounding.has_value()};
}

void append_state(std::vector<std::byte>& out, const TrainState& state) {
  append_rows(out, state.parameters);
  append_rows(out, state.adam.first);
  append_rows(out, state.adam.second);
  append_rows(out, state.statistics);
  if (state.rounding) {
    const ErrorCosts& costs = state.rounding->costs;
    for (const auto* numbers : {&costs.weights, &costs.sh_factors, &costs.scale, &costs.rotation})
      append_floats(out, *numbers);
    append_rows(out, state.rounding->offsets);
  }
  for (std::uint8_t degree : state.degrees) out.push_back(static_cast<std::byte>(degree));
  if (!state.networks) return;
  append_rows(out, state.networks->latents);
  append_rows(out, state.networks->adam.first);
  append_rows(out, state.networks->adam.second);
  append_floats(out, to_floats(state.networks->model));
}

Expected<void> take_state(const std::byte* in, const StateLayout& layout, TrainState& state) {
  const auto take = [&](int rows, std::initializer_list<PlanarFloats*> all) {
    for (PlanarFloats* planes : all) {
      *planes = PlanarFloats(rows, layout.splats);
      in = take_rows(in, *planes);
    }
  };
  take(row::count(layout.sh_degree), {&state.parameters, &state.adam.first, &state.adam.second});
  take(statistic::count, {&state.statistics});
  if (state.rounding) {
    in = take_costs(in, layout, state.rounding->costs);
    take(row::count(layout.sh_degree), {&state.rounding->offsets});
  }
  if (layout.own_degrees) {
    state.degrees.resize(layout.splats);
    for (std::uint8_t& degree : state.degrees)
      degree = std::min<std::uint8_t>(std::to_integer<std::uint8_t>(*in++),
                                      static_cast<std::uint8_t>(layout.sh_degree));
  }
  if (!layout.networks()) return {};
  NetworkState networks;
  take(networks::kShColumns, {&networks.latents, &networks.adam.first, &networks.adam.second});
  std::vector<float> floats;
  take_floats(in, layout.model_floats(), floats);
  auto model = model_from_floats(layout.psi, layout.phi, floats);
  if (!model) return std::unexpected(model.error());
  networks.model = std::move(*model);
  state.networks = std::move(networks);
  return {};
}

}  // namespace fluxgs
