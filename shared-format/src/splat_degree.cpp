#include "fluxgs/splat_degree.h"

namespace fluxgs {

int sh_degree_of(const SplatCloud& cloud, std::size_t i) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  std::size_t used = rest;
  while (used > 0 && cloud.sh_rest[i * rest + used - 1] == glm::vec3(0)) --used;
  int degree = 0;
  while (static_cast<std::size_t>(sh_rest_count(degree)) < used) ++degree;
  return degree;
}

}  // namespace fluxgs
