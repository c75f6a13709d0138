// One splat by itself, on its way from a file into a SplatCloud.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

/// The attributes as in a SplatCloud, though not necessarily in its frame.
struct SplatValues {
  glm::vec3 position, log_scale, sh_dc;
  glm::quat rotation;
  float opacity_logit;
  std::array<glm::vec3, 15> sh_rest;
};

/// Store the first `rest` coefficients; those that the cloud has beyond them keep their zeros.
inline void store_splat(const SplatValues& from, std::size_t rest, SplatCloud& cloud,
                        std::size_t i) {
  cloud.positions[i] = from.position;
  cloud.log_scales[i] = from.log_scale;
  cloud.rotations[i] = from.rotation;
  cloud.opacity_logits[i] = from.opacity_logit;
  cloud.sh_dc[i] = from.sh_dc;
  const auto stride = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  std::copy_n(from.sh_rest.data(), rest, cloud.sh_rest.data() + i * stride);
}

}  // namespace fluxgs::io
