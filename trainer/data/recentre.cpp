#include "trainer/data/recentre.h"

#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "trainer/core/median.h"
#include "trainer/data/middle.h"

namespace fluxgs {
namespace {

constexpr double kMaxError = 2;  // pixels

double median_focal_length(const Source& source) {
  std::vector<double> lengths;
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames) lengths.push_back(frame.lens.fx);
  return median(std::move(lengths)).value_or(0);
}

}  // namespace

void recentre(Source& source) {
  const std::vector<glm::dvec3> positions = camera_positions(source);
  if (positions.empty()) return;
  const Middle cameras = middle_of(positions);
  const double rounding = std::ldexp(glm::length(cameras.centre), -24);
  if (!(cameras.radius > 0) || !std::isfinite(rounding) ||
      rounding / cameras.radius * median_focal_length(source) <= kMaxError)
    return;
  const double grid = std::ldexp(1.0, std::ilogb(cameras.radius) + 8);
  const glm::dvec3 moved = glm::round(cameras.centre / grid) * grid;
  if (moved == glm::dvec3(0.0)) return;
  for (auto* frames : {&source.frames, &source.test_frames})
    for (SourceFrame& frame : *frames) frame.translation += frame.rotation * moved;
  for (glm::dvec3& point : source.points) point -= moved;
  source.warnings.push_back(
      fmt::format("poses and points are moved to the origin, by {:.10g}, {:.10g}, {:.10g}: so far "
                  "away, numbers of 32 bits are too coarse for a scene",
                  -moved.x, -moved.y, -moved.z));
}

}  // namespace fluxgs
