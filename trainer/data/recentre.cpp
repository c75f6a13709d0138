#include "trainer/data/recentre.h"

#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "trainer/core/median.h"

namespace fluxgs {
namespace {

constexpr double kMaxError = 2;  // pixels

/// Where cameras are, how far apart, and with which focal length: medians.
struct Place {
  glm::dvec3 centre{0.0};
  double spread = 0;  // from the centre
  double focal_length = 0;
};

Place place_of(const Source& source) {
  std::vector<glm::dvec3> positions;
  std::vector<double> values;
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames) {
      positions.push_back(camera_position(frame));
      values.push_back(frame.lens.fx);
    }
  Place place;
  if (positions.empty()) return place;
  place.focal_length = *median(values);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = positions[i][axis];
    place.centre[axis] = *median(values);
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = glm::distance(positions[i], place.centre);
  place.spread = *median(values);
  return place;
}

}  // namespace

void recentre(Source& source) {
  const Place place = place_of(source);
  const double rounding = std::ldexp(glm::length(place.centre), -24);
  if (!(place.spread > 0) || !std::isfinite(rounding) ||
      rounding / place.spread * place.focal_length <= kMaxError)
    return;
  const double grid = std::ldexp(1.0, std::ilogb(place.spread) + 8);
  const glm::dvec3 moved = glm::round(place.centre / grid) * grid;
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
