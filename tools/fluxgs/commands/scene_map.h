// Turning, resizing and moving a whole scene from the command line.
#pragma once

#include <string>

#include "fluxgs/io/scene_file.h"
#include "fluxgs/transform.h"

namespace CLI {
class App;
}

namespace fluxgs::cli {

/// Options that map a scene, in the axes that `fluxgs info` shows: those of a 3DGS .ply, y down.
struct MapOptions {
  std::string up;             ///< direction that becomes up: "-z", or "x,y,z"
  glm::dvec3 rotate{0.0};     ///< degrees about the axes x, y, z, one after the other
  double scale = 1;           ///< factor of all lengths
  glm::dvec3 translate{0.0};  ///< scene units, after all others
  bool turns_up() const { return !up.empty(); }
};

/// --up, --rotate, --scale, --translate.
void add_map_options(CLI::App& command, MapOptions& options);

/// The map that options ask for: up, then turns, then the scale, then the shift.
AffineMap map_of(const MapOptions& options);

/// Maps splats and start view.
void map_scene(const MapOptions& options, SceneFile& scene);

}  // namespace fluxgs::cli
