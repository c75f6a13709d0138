// Reads a scene as it is drawn into as much memory as there is: where not all of it fits, with
// harmonics of a lower degree, then with the splats that add most.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "fluxgs/byte_source.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/io/scene_estimate.h"
#include "render/render_cloud.h"

namespace fluxgs::viewer {

struct LoadedScene {
  render::RenderCloud cloud;         ///< in order, see put_in_order()
  std::size_t dropped = 0;           ///< splats left out for a NaN or infinity
  std::optional<InitialView> start;  ///< the start view that the file names
  bool is_coarse = false;            ///< the rest of it is still to come
};

/// What of a scene fits.
struct ScenePlan {
  std::size_t count = 0;  ///< splats
  int sh_degree = 0;
};

/// As many splats as fit with harmonics of degree 1 into so many bytes, and then the highest degree
/// with which they fit. Not all splats: 8 bytes a splat go for ranking them.
ScenePlan plan_scene(const ComingSplats& coming, std::uint64_t memory);

/// What is said where a scene needs more memory than it may have.
std::unexpected<Error> needs_memory(const std::string& name, std::uint64_t needed,
                                    std::uint64_t allowed);

/// Reads a scene. `memory`: bytes for the cloud, and again for what the reader holds meanwhile;
/// an error where that is too little for a twentieth of the splats. A source is read twice where
/// the splats that add most are looked for; `second` is called in between. `planned` gets the
/// estimate with what the cloud will take. `coarse` gets what has come of a file whose splats lie
/// in the order of what they add, each time a part of it is there: where the file names its start
/// view, which need not wait for the others then, and memory for a second cloud is there.
Expected<LoadedScene> read_within(std::uint64_t memory, const SceneFormat& format,
                                  const ByteSource& source, const std::string& name,
                                  const std::function<void(const SceneEstimate&)>& planned = {},
                                  const std::function<void()>& second = {},
                                  const std::function<void(LoadedScene&&)>& coarse = {});

}  // namespace fluxgs::viewer
