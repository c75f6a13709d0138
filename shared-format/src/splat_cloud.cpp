#include "fluxgs/splat_cloud.h"

#include <cmath>

namespace fluxgs {
namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

bool is_finite(const SplatCloud& cloud, std::size_t i) {
  const std::size_t rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const glm::quat& q = cloud.rotations[i];
  bool ok = finite(cloud.positions[i]) && finite(cloud.log_scales[i]) && finite(cloud.sh_dc[i]) &&
            std::isfinite(cloud.opacity_logits[i]) && std::isfinite(q.w) && std::isfinite(q.x) &&
            std::isfinite(q.y) && std::isfinite(q.z);
  for (std::size_t k = 0; ok && k < rest; ++k) ok = finite(cloud.sh_rest[i * rest + k]);
  return ok;
}

std::size_t count_non_finite(const SplatCloud& cloud) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) count += !is_finite(cloud, i);
  return count;
}

std::size_t drop_non_finite(SplatCloud& cloud) {
  const std::size_t rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud, i)) continue;
    if (kept != i) {
      cloud.positions[kept] = cloud.positions[i];
      cloud.log_scales[kept] = cloud.log_scales[i];
      cloud.rotations[kept] = cloud.rotations[i];
      cloud.opacity_logits[kept] = cloud.opacity_logits[i];
      cloud.sh_dc[kept] = cloud.sh_dc[i];
      for (std::size_t k = 0; k < rest; ++k)
        cloud.sh_rest[kept * rest + k] = cloud.sh_rest[i * rest + k];
    }
    ++kept;
  }
  const std::size_t dropped = cloud.size() - kept;
  cloud.resize(kept);
  return dropped;
}

}  // namespace fluxgs
