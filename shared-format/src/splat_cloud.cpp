#include "fluxgs/splat_cloud.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/math/finite.h"

namespace fluxgs {
namespace {

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The same as is_finite() of every splat, but fast.
bool all_finite(const SplatCloud& cloud) {
  const auto finite_vectors = [](const std::vector<glm::vec3>& list) {
    return list.empty() || math::all_finite({&list[0].x, 3 * list.size()});
  };
  const auto& q = cloud.rotations;
  return finite_vectors(cloud.positions) && finite_vectors(cloud.log_scales) &&
         finite_vectors(cloud.sh_dc) && finite_vectors(cloud.sh_rest) &&
         math::all_finite(cloud.opacity_logits) &&
         (q.empty() || math::all_finite({&q[0][0], 4 * q.size()}));
}

/// The first `kept` of every `coefficients` SH coefficients.
std::vector<glm::vec3> first_of_each(const std::vector<glm::vec3>& sh, std::size_t coefficients,
                                     std::size_t kept) {
  std::vector<glm::vec3> result;
  for (std::size_t at = 0; kept > 0 && at < sh.size(); at += coefficients)
    for (std::size_t k = 0; k < kept; ++k) result.push_back(sh[at + k]);
  return result;
}

}  // namespace

SplatCloud in_order(const SplatCloud& cloud, std::span<const std::uint32_t> order) {
  SplatCloud result;
  result.sh_degree = cloud.sh_degree;
  result.filter = cloud.filter;
  result.resize(order.size());
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::uint32_t i = order[k];
    result.positions[k] = cloud.positions[i];
    result.log_scales[k] = cloud.log_scales[i];
    result.rotations[k] = cloud.rotations[i];
    result.opacity_logits[k] = cloud.opacity_logits[i];
    result.sh_dc[k] = cloud.sh_dc[i];
    std::copy_n(cloud.sh_rest.data() + rest * i, rest, result.sh_rest.data() + rest * k);
  }
  return result;
}

void limit_sh_degree(SplatCloud& cloud, int degree) {
  if (cloud.sh_degree <= degree) return;
  cloud.sh_rest =
      first_of_each(cloud.sh_rest, static_cast<std::size_t>(sh_rest_count(cloud.sh_degree)),
                    static_cast<std::size_t>(sh_rest_count(degree)));
  cloud.sh_degree = degree;
}

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
  if (all_finite(cloud)) return 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) count += !is_finite(cloud, i);
  return count;
}

std::size_t drop_non_finite(SplatCloud& cloud) {
  if (all_finite(cloud)) return 0;
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
