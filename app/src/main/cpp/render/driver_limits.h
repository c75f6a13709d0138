// Ways of drawing that a driver gets wrong, and that the renderer then does without.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gl/api.h"

namespace fluxgs::render {

/// Each is a rung of the ladder that bench/driver_check.h climbs down.
struct DriverLimits {
  bool no_gpu_sort = false;        ///< sort on the CPU
  bool no_vertex_storage = false;  ///< the vertex stage reads textures in place of storage buffers
  bool no_float_targets = false;   ///< blend in 8 bits
  bool no_compute = false;         ///< project in fragment shaders, sort on the CPU
  bool no_fragment_projection = false;  ///< without compute, project in vertex shaders
  bool operator==(const DriverLimits&) const = default;

  /// The names of those that are set, as above.
  std::vector<std::string> names() const;
};

/// The limits of which the text has the names, in any order; other words are passed over.
DriverLimits limits_named(std::string_view names);

/// Takes from a context what its driver gets wrong: whatever is made with it later does without.
void apply(const DriverLimits& limits, gl::Api& api);

}  // namespace fluxgs::render
