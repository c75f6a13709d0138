// A scene of any input, for the targets that write scenes.
#pragma once

#include <algorithm>
#include <cstring>
#include <optional>

#include "fluxgs/io/scene.h"
#include "harness.h"

namespace fluxgs::fuzz {

/// A byte for the degree, then the floats of each splat. None is limited: NaN, infinities and
/// denormals are there to be met.
inline SplatCloud as_floats(Input input, std::size_t most) {
  Parameters parameters(input);
  SplatCloud cloud;
  cloud.sh_degree = parameters.byte() % 4;
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const std::size_t each = sizeof(float) * (14 + 3 * rest);
  cloud.resize(std::min(parameters.rest().size() / each, most));
  const std::byte* from = parameters.rest().data();
  const auto fill = [&](auto& list) {
    if (list.empty()) return;
    std::memcpy(list.data(), from, list.size() * sizeof list[0]);
    from += list.size() * sizeof list[0];
  };
  fill(cloud.positions);
  fill(cloud.log_scales);
  fill(cloud.rotations);
  fill(cloud.opacity_logits);
  fill(cloud.sh_dc);
  fill(cloud.sh_rest);
  return cloud;
}

/// The scene that the input is in any format; if it is none, the one that its bytes are as plain
/// floats. Nothing if it has more splats than `most`.
inline std::optional<SplatCloud> scene_of(Input input, std::size_t most) {
  auto scene = read_scene(input, "x");
  if (!scene) return as_floats(input, most);
  if (scene->cloud.size() > most) return std::nullopt;
  return std::move(scene->cloud);
}

}  // namespace fluxgs::fuzz
