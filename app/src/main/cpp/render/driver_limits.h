// Ways of drawing that a driver gets wrong, and that the renderer then does without.
#pragma once

#include <string>
#include <vector>

namespace fluxgs::render {

/// Each is a rung of the ladder that bench/driver_check.h climbs down.
struct DriverLimits {
  bool no_gpu_sort = false;        ///< sort on the CPU
  bool no_vertex_storage = false;  ///< the vertex stage reads textures in place of storage buffers
  bool no_float_targets = false;   ///< blend in 8 bits
  bool operator==(const DriverLimits&) const = default;

  /// The names of those that are set, as above.
  std::vector<std::string> names() const {
    std::vector<std::string> set;
    if (no_gpu_sort) set.emplace_back("no_gpu_sort");
    if (no_vertex_storage) set.emplace_back("no_vertex_storage");
    if (no_float_targets) set.emplace_back("no_float_targets");
    return set;
  }
};

}  // namespace fluxgs::render
