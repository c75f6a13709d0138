#include "trainer/compress/quantization_aware.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/gtc/quaternion.hpp>

#include "fluxgs/io/gltf.h"
#include "trainer/compress/view_sensitivity.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

constexpr const char* kName = "compact .glb";

/// to += sign·what.
void add(PlanarFloats& to, const PlanarFloats& what, float sign) {
  for (int r = 0; r < to.rows(); ++r)
    for (std::size_t i = 0; i < to.size(); ++i) to.row(r)[i] += sign * what.row(r)[i];
}

/// q·h of the unit ±1, ±i, ±j or ±k that h is nearest to.
glm::dquat times_nearest_unit(const glm::dquat& q, const glm::dquat& h) {
  const double parts[] = {h.w, h.x, h.y, h.z};
  const auto largest =
      std::ranges::max_element(parts, {}, [](double part) { return std::abs(part); });
  double unit[4] = {};
  unit[largest - parts] = std::copysign(1.0, *largest);
  return q * glm::dquat(unit[0], unit[1], unit[2], unit[3]);
}

void put_quaternion(PlanarFloats& rows, std::size_t i, const glm::dquat& q) {
  const double parts[] = {q.w, q.x, q.y, q.z};
  for (int c = 0; c < 4; ++c) rows.row(row::rotation + c)[i] = static_cast<float>(parts[c]);
}

/// Where rotations q of a state became |q|⁻¹·q·h with a half turn h, their gradients become
/// |q|·g·h: moments of quaternions that came before follow them.
void follow_rotations(const PlanarFloats& before, const std::vector<glm::quat>& after,
                      AdamState& adam) {
  for (std::size_t i = 0; i < after.size(); ++i) {
    const glm::dquat q = rotation_of(before, i);
    const double length = glm::length(q);
    const glm::dquat h =
        length > 0 ? glm::conjugate(q) * glm::dquat(after[i]) : glm::dquat(1, 0, 0, 0);
    put_quaternion(adam.first, i, times_nearest_unit(rotation_of(adam.first, i), h) * length);
    const glm::dquat second =
        times_nearest_unit(rotation_of(adam.second, i), h) * (length * length);
    put_quaternion(
        adam.second, i,
        {std::abs(second.w), std::abs(second.x), std::abs(second.y), std::abs(second.z)});
  }
}

}  // namespace

Expected<CompactTrial> compact_within(const SplatCloud& cloud, const SplatCloud& shown,
                                      const CompactGoal& goal, CompactOptions start,
                                      const Threads& threads,
                                      const std::function<void(const CompactTrial&)>& on_trial) {
  start.costs = seen_costs(goal.cameras, shown, start.networks.has_value(), goal.render, threads);
  const SceneError error(shown, spread_cameras(goal.cameras, kMeasuringViews), goal.render,
                         threads);
  return CompactSearch(cloud, shown, error, std::move(start), on_trial).within_loss(goal.decibels);
}

Expected<std::vector<std::byte>> round_parameters(TrainState& state) {
  RoundingState& rounding = *state.rounding;
  const int degree = sh_degree_of(state.parameters);
  PlanarFloats exact = state.parameters;
  if (rounding.offsets.size() == exact.size()) add(exact, rounding.offsets, -1);
  SplatCloud cloud = to_cloud(exact, degree);
  // Offsets must be between quaternions that mean the same of four half turns
  canonicalize_rotations(cloud);
  const CompactOptions options{.steps = rounding.steps, .costs = rounding.costs};
  auto file = encode_compact_glb(cloud, options, kName);
  if (!file) return std::unexpected(file.error());
  const auto stored = read_glb(*file, kName);
  if (!stored) return std::unexpected(stored.error());
  if (stored->cloud.size() != cloud.size())
    return fail(kName, "splats", "not all of them are finite");
  follow_rotations(exact, cloud.rotations, state.adam);
  const std::vector<std::uint32_t> order = compact_order(cloud);
  rearrange(state, order, order);
  state.parameters = to_parameters(stored->cloud, degree);
  rounding.offsets = state.parameters;
  add(rounding.offsets, to_parameters(in_order(cloud, order), degree), -1);
  return file;
}

}  // namespace fluxgs
