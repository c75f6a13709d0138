#include "trainer/compress/rounding.h"

#include <utility>

#include "fluxgs/io/gltf.h"
#include "trainer/compress/seen_splats.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

constexpr const char* kName = "compact .glb";

/// to += sign·what.
void add(PlanarFloats& to, const PlanarFloats& what, float sign) {
  for (int r = 0; r < to.rows(); ++r)
    for (std::size_t i = 0; i < to.size(); ++i) to.row(r)[i] += sign * what.row(r)[i];
}

}  // namespace

Expected<CompactTrial> compact_within(const SplatCloud& cloud, const std::vector<Camera>& cameras,
                                      const RenderOptions& render, double decibels,
                                      CompactOptions start, const Threads& threads,
                                      const std::function<void(const CompactTrial&)>& on_trial) {
  start.costs = seen_costs(cameras, cloud, start.networks.has_value(), render, threads);
  const SceneError error(cloud, spread_cameras(cameras, kMeasuringViews), render, threads);
  return CompactSearch(cloud, error, std::move(start), on_trial).within_loss(decibels);
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
  const std::vector<std::uint32_t> order = compact_order(cloud);
  rearrange(state, order, order);
  state.parameters = to_parameters(stored->cloud, degree);
  rounding.offsets = state.parameters;
  add(rounding.offsets, to_parameters(in_order(cloud, order), degree), -1);
  return file;
}

}  // namespace fluxgs
