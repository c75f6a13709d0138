// The same as stability.cpp for the compact codec, which takes longer: a scene that it accepts it
// also decodes, to as many finite splats in the order that it promises, and encodes again.
#include <cmath>

#include "codec/compact.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf.h"
#include "harness.h"
#include "scene_of.h"

namespace fluxgs::fuzz {
namespace {

constexpr std::size_t kMaxSplats = 64;

// The order changes, the attributes by at most their steps; of these only that of the positions is
// a plain bound (see codec/compact.h).
void check_positions(const SplatCloud& before, const SplatCloud& after, double step) {
  const auto order = codec::position_order(before.positions, step);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const glm::dvec3 from = before.positions[order[k]], to = after.positions[k];
    for (int c = 0; c < 3; ++c) {
      const double float_error = 1e-7 * std::abs(from[c]);
      require(std::abs(from[c] - to[c]) <= step / 2 + float_error,
              "compact: a position is off by at most half a step");
    }
  }
}

void try_compact(SplatCloud cloud) {
  const CompactOptions options;
  drop_non_finite(cloud);  // compact.h: the cloud is finite
  for (int i = 0; i < 2; ++i) {
    const auto bytes = codec::encode_compact(cloud, options);
    if (!bytes) return check_error(bytes.error());
    auto back = codec::decode_compact(*bytes, cloud.size(), cloud.sh_degree);
    if (!back) broken("compact: reads its own: " + back.error().message());
    require(back->size() == cloud.size(), "compact: the number of splats is stable");
    check_cloud(*back);
    check_positions(cloud, *back, options.steps.position);
    cloud = std::move(*back);
  }
}

// The same in a file.
void try_files(const SplatCloud& cloud) {
  const std::size_t splats = cloud.size() - count_non_finite(cloud);
  for (const bool plain : {false, true}) {
    const CompactOptions options{default_quantization_steps(cloud), plain};
    const auto file = encode_compact_glb(cloud, options, "x");
    if (!file) {
      check_error(file.error());
      continue;
    }
    const auto scene = read_glb(*file, "x");
    if (!scene) broken("compact .glb: reads its own: " + scene.error().message());
    check_scene(*scene);
    require(scene->cloud.size() == splats && scene->dropped == 0,
            "compact .glb: the number of splats is stable");
  }
}

}  // namespace

FLUXGS_FUZZ_TARGET(compact_stability) {
  auto cloud = scene_of(input, kMaxSplats);
  if (!cloud) return Worth::forget;
  try_files(*cloud);
  try_compact(std::move(*cloud));
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
