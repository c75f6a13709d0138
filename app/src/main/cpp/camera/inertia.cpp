#include "camera/inertia.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::camera {

Glide thrown(const glm::dvec2& velocity, const GlideOptions& options) {
  const double speed = std::hypot(velocity.x, velocity.y);
  if (!(speed >= options.slowest) || !std::isfinite(speed)) return {};
  return {velocity * std::min(1.0, options.fastest / speed)};
}

glm::dvec2 advance(Glide& glide, double seconds, const GlideOptions& options) {
  const double speed = glm::length(glide.velocity);
  if (!(speed > 0) || !(seconds > 0)) return glm::dvec2(0.0);
  const double rest = options.decay * std::log(std::max(speed / options.slowest, 1.0));
  const bool over = seconds >= rest;
  // The integral of v·exp(−t/decay)
  const double share = -std::expm1(-(over ? rest : seconds) / options.decay);
  const glm::dvec2 way = glide.velocity * (options.decay * share);
  glide.velocity *= over ? 0.0 : 1.0 - share;
  return way;
}

void add(PointerTrail& trail, double time, const glm::dvec2& position) {
  trail.samples[trail.count++ % trail.samples.size()] = {time, position};
}

glm::dvec2 velocity(const PointerTrail& trail, double now) {
  constexpr double kWindow = 0.1, kShortest = 1e-3;
  const std::size_t kept = std::min(trail.count, trail.samples.size());
  if (kept == 0) return glm::dvec2(0.0);
  const PointerTrail::Sample& last = trail.samples[(trail.count - 1) % trail.samples.size()];
  PointerTrail::Sample first = last;
  for (std::size_t back = 2; back <= kept; ++back) {
    const PointerTrail::Sample& s = trail.samples[(trail.count - back) % trail.samples.size()];
    if (s.time < now - kWindow) break;
    first = s;
  }
  return (last.position - first.position) / std::max(now - first.time, kShortest);
}

}  // namespace fluxgs::camera
