#include "trainer/train/store_scene.h"

#include <utility>

#include "fluxgs/io/gltf.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/compression.h"
#include "trainer/data/dataset.h"
#include "trainer/paper/export_networks.h"
#include "trainer/paper/network_colors.h"

namespace fluxgs {
namespace {

Expected<StoredScene> opened(std::vector<std::byte> file) {
  auto scene = read_glb(file, kCompactFileName);
  if (!scene) return std::unexpected(scene.error());
  return StoredScene{.file = std::move(file), .cloud = std::move(scene->cloud)};
}

/// A scene to be stored, with everything else that goes into the file.
struct Candidate {
  SplatCloud cloud;
  CompactOptions options;
};

Candidate plain(SplatCloud cloud) {
  const QuantizationSteps steps = default_quantization_steps(cloud);
  return {std::move(cloud), {.steps = steps}};
}

/// The phase whose networks make the colours, if there is one and it has begun.
const NetworkColors* network_colors(const Schedule& schedule) {
  for (const auto& phase : schedule.phases)
    if (const auto* found = dynamic_cast<const NetworkColors*>(phase.get()))
      return found->model() ? found : nullptr;
  return nullptr;
}

Expected<Candidate> with_networks(const AppearanceModel& model, const TrainState& state) {
  const PlanarFloats& latents = state.attached.at(kLatents).values;
  auto exported = export_networks(model, latents);
  if (!exported) return std::unexpected(exported.error());
  Candidate c = plain(cloud_for_networks(model, state.parameters, latents));
  c.options.networks = std::move(*exported);
  return c;
}

}  // namespace

Expected<StoredScene> store_scene(const Trainer& trainer, const std::vector<View>& views,
                                  const Threads& threads, const WorkControl& control) {
  const TrainState& state = trainer.state;
  if (state.parameters.size() == 0) {
    auto empty = encode_compact_glb(trainer.cloud(), {}, kCompactFileName);
    return empty ? opened(std::move(*empty)) : std::unexpected(empty.error());
  }

  const SplatCloud shown = trainer.cloud();
  const CompactGoal goal{cameras_of(views), trainer.options.render, trainer.compressed_psnr(),
                         trainer.options.iterations};
  const NetworkColors* networks = network_colors(trainer.schedule());
  const ProgressParts parts(control.progress, {1, networks ? 1.0 : 0.0});
  const auto smallest = [&](const Candidate& c, std::size_t part) {
    return compact_within(c.cloud, shown, goal, c.options, threads,
                          {parts.part(part), control.stop});
  };
  auto direct = smallest(plain(shown), 0);
  if (!direct) return std::unexpected(direct.error());
  if (!networks) return opened(std::move(direct->file));

  auto candidate = with_networks(*networks->model(), state);
  if (candidate) candidate->cloud.filter = shown.filter;
  auto made = candidate ? smallest(*candidate, 1) : std::unexpected(candidate.error());
  const std::size_t direct_bytes = direct->file.size();
  if (!made && control.stopped()) return std::unexpected(made.error());
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
