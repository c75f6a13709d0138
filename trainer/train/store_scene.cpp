#include "trainer/train/store_scene.h"

#include <utility>

#include "fluxgs/io/gltf.h"
#include "trainer/compress/quantization_aware.h"
#include "trainer/paper/export_networks.h"

namespace fluxgs {
namespace {

constexpr const char* kName = "compact .glb";

Expected<StoredScene> opened(std::vector<std::byte> file) {
  auto scene = read_glb(file, kName);
  if (!scene) return std::unexpected(scene.error());
  return StoredScene{.file = std::move(file), .cloud = std::move(scene->cloud)};
}

Expected<StoredScene> store_rounded(TrainState state) {
  auto file = round_parameters(state);
  if (!file) return std::unexpected(file.error());
  return opened(std::move(*file));
}

/// What is to be stored, with what else goes into the file.
struct Candidate {
  SplatCloud cloud;
  CompactOptions options;
};

Candidate plain(SplatCloud cloud) {
  const CompactSteps steps = default_compact_steps(cloud);
  return {std::move(cloud), {.steps = steps}};
}

Expected<Candidate> with_networks(const NetworkState& networks, const PlanarFloats& parameters) {
  auto exported = export_networks(networks.model, networks.latents);
  if (!exported) return std::unexpected(exported.error());
  Candidate c = plain(cloud_for_networks(networks.model, parameters, networks.latents));
  c.options.networks = std::move(*exported);
  return c;
}

}  // namespace

Expected<StoredScene> store_scene(const Trainer& trainer, const std::vector<View>& views,
                                  const Threads& threads,
                                  const std::function<void(const CompactTrial&)>& on_trial) {
  const TrainState& state = trainer.state();
  if (state.parameters.size() == 0) {
    auto empty = encode_compact_glb(trainer.cloud(), {}, kName);
    return empty ? opened(std::move(*empty)) : std::unexpected(empty.error());
  }
  if (state.rounding) return store_rounded(state);

  const SplatCloud shown = trainer.cloud();
  const CompactGoal goal{cameras_of(views), trainer.options().render, trainer.stored_psnr()};
  const auto smallest = [&](const Candidate& c) {
    return compact_within(c.cloud, shown, goal, c.options, threads, on_trial);
  };
  auto direct = smallest(plain(shown));
  if (!direct) return std::unexpected(direct.error());
  if (!state.networks) return opened(std::move(direct->file));

  auto candidate = with_networks(*state.networks, state.parameters);
  auto made = candidate ? smallest(*candidate) : std::unexpected(candidate.error());
  const std::size_t direct_bytes = direct->file.size();
  if (!made) {
    auto without = opened(std::move(direct->file));
    if (without) without->networks_error = made.error();
    return without;
  }
  const std::size_t made_bytes = made->file.size();
  auto stored = opened(made_bytes < direct_bytes ? std::move(made->file) : std::move(direct->file));
  if (!stored) return stored;
  stored->with_networks = made_bytes;
  stored->without_networks = direct_bytes;
  return stored;
}

}  // namespace fluxgs
