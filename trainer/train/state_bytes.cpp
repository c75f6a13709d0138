#include "trainer/train/state_bytes.h"

#include <algorithm>
#include <cstring>
#include <span>

namespace fluxgs {
namespace {

constexpr int kMaxRows = 1000;
constexpr std::uint64_t kMaxSplats = std::uint64_t{1} << 40;
constexpr std::uint64_t kMaxPhaseValues = 1 << 24;

void append(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void append_rows(std::vector<std::byte>& out, const PlanarFloats& planes) {
  for (int r = 0; r < planes.rows(); ++r)
    append(out, std::as_bytes(std::span(planes.row(r), planes.size())));
}

const std::byte* take_bytes(const std::byte* in, std::span<std::byte> to) {
  if (!to.empty()) std::memcpy(to.data(), in, to.size());
  return in + to.size();
}

const std::byte* take_rows(const std::byte* in, int rows, std::uint64_t splats,
                           PlanarFloats& planes) {
  planes = PlanarFloats(rows, splats);
  for (int r = 0; r < rows; ++r)
    in = take_bytes(in, std::as_writable_bytes(std::span(planes.row(r), splats)));
  return in;
}

}  // namespace

std::optional<std::uint64_t> StateLayout::size() const {
  if (splats > kMaxSplats || sh_degree < 0 || sh_degree > 3) return {};
  int rows = 3 * row::count(sh_degree) + statistic::count;
  for (const Attached& a : attached) {
    if (a.rows < 1 || a.rows > kMaxRows || attached.size() > 10) return {};
    rows += a.rows;
  }
  std::uint64_t values = 0;
  for (const PhaseValues& v : phase_values) {
    if (v.count > kMaxPhaseValues || phase_values.size() > 100) return {};
    values += v.count;
  }
  return splats * (static_cast<std::uint64_t>(rows) * sizeof(float) + (own_degrees ? 1 : 0)) +
         values * sizeof(double);
}

StateLayout layout_of(const TrainState& state) {
  StateLayout layout{.splats = state.parameters.size(),
                     .sh_degree = sh_degree_of(state.parameters),
                     .own_degrees = !state.degrees.empty()};
  for (const auto& [name, attached] : state.attached)
    layout.attached.push_back({name, attached.values.rows(), attached.moments});
  for (const auto& [name, values] : state.phase_values)
    layout.phase_values.push_back({name, values.size()});
  return layout;
}

void append_state(std::vector<std::byte>& out, const TrainState& state) {
  for (const PlanarFloats* planes :
       {&state.parameters, &state.adam.first, &state.adam.second, &state.statistics})
    append_rows(out, *planes);
  for (const auto& [name, attached] : state.attached) append_rows(out, attached.values);
  for (const auto& [name, values] : state.phase_values)
    append(out, std::as_bytes(std::span(values)));
  append(out, std::as_bytes(std::span(state.degrees)));
}

void take_state(const std::byte* in, const StateLayout& layout, TrainState& state) {
  const int rows = row::count(layout.sh_degree);
  for (PlanarFloats* planes : {&state.parameters, &state.adam.first, &state.adam.second})
    in = take_rows(in, rows, layout.splats, *planes);
  in = take_rows(in, statistic::count, layout.splats, state.statistics);
  for (const StateLayout::Attached& a : layout.attached) {
    SplatValues& attached = state.attached[a.name];
    attached.moments = a.moments;
    in = take_rows(in, a.rows, layout.splats, attached.values);
  }
  for (const StateLayout::PhaseValues& v : layout.phase_values) {
    std::vector<double>& values = state.phase_values[v.name];
    values.resize(v.count);
    in = take_bytes(in, std::as_writable_bytes(std::span(values)));
  }
  if (!layout.own_degrees) return;
  state.degrees.resize(layout.splats);
  take_bytes(in, std::as_writable_bytes(std::span(state.degrees)));
  for (std::uint8_t& degree : state.degrees)
    degree = std::min(degree, static_cast<std::uint8_t>(layout.sh_degree));
}

}  // namespace fluxgs
