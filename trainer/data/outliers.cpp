#include "trainer/data/outliers.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "trainer/data/file_list.h"
#include "trainer/data/middle.h"

namespace fluxgs {
namespace {

constexpr std::size_t kFewest = 5;  // of which a median says something

/// A sphere around the median position that all but stray positions lie in.
struct Bounds {
  glm::dvec3 centre{0.0};
  double radius = 0;
  bool holds(const glm::dvec3& p) const { return glm::distance(p, centre) <= radius; }
};

Bounds bounds_of(const std::vector<glm::dvec3>& positions, double factor) {
  const Middle middle = middle_of(positions);
  return {middle.centre, factor * middle.radius};
}

void remove_stray_frames(Source& source) {
  const std::vector<glm::dvec3> positions = camera_positions(source);
  if (positions.size() < kFewest) return;
  const Bounds bounds = bounds_of(positions, kStrayCamera);
  if (bounds.radius <= 0) return;  // Most are in one place: no size to compare with
  FileList stray;
  const auto is_stray = [&](const SourceFrame& frame) {
    if (bounds.holds(camera_position(frame))) return false;
    stray.add(frame.name);
    return true;
  };
  std::erase_if(source.frames, is_stray);
  std::erase_if(source.test_frames, is_stray);
  source.skipped_images += stray.size();
  if (!stray.empty())
    source.warnings.push_back(fmt::format(
        "left out, since their cameras are more than {:g} times as far away as most: {}",
        kStrayCamera, stray.text()));
}

void remove_stray_points(Source& source) {
  if (source.points.size() < kFewest) return;
  const std::vector<glm::dvec3> positions = source.points;
  const Bounds bounds = bounds_of(positions, kStrayPoint);
  if (bounds.radius <= 0) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < source.points.size(); ++i) {
    if (!bounds.holds(positions[i])) continue;
    source.points[kept] = source.points[i];
    source.point_colors[kept++] = source.point_colors[i];
  }
  const std::size_t stray = source.points.size() - kept;
  source.points.resize(kept);
  source.point_colors.resize(kept);
  if (stray > 0)
    source.warnings.push_back(
        fmt::format("points left out, since they are more than {:g} times as far away as most: {}",
                    kStrayPoint, stray));
}

}  // namespace

void remove_outliers(Source& source) {
  remove_stray_frames(source);
  remove_stray_points(source);
}

}  // namespace fluxgs
