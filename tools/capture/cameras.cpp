#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "tools/capture/capture.h"
#include "trainer/core/random.h"

namespace fluxgs::capture {
namespace {

using glm::dvec3;

double fraction(double x) { return x - std::floor(x); }

Camera look_at(const CaptureOptions& options, const dvec3& from, const dvec3& target) {
  const dvec3 forward = glm::normalize(target - from);
  const dvec3 right = glm::normalize(glm::cross(forward, dvec3(0, 0, 1)));
  const dvec3 down = glm::cross(forward, right);
  Camera camera{.name = {}, .width = options.width, .height = options.height};
  // 48° across the longer side.
  camera.fx = camera.fy = 1.12 * std::max(options.width, options.height);
  camera.cx = options.width / 2.0;
  camera.cy = options.height / 2.0;
  camera.rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.translation = -(camera.rotation * from);
  return camera;
}

/// Views that cover the dome evenly: the R3 sequence (Roberts 2018) over azimuth, height and
/// distance, from an offset that the seed chooses.
std::vector<Camera> dome(const CaptureOptions& options, int count, Random& random) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr double kR3[] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const double offset[] = {uniform(random), uniform(random), uniform(random)};
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const auto place = [&](int axis) { return fraction(offset[axis] + i * kR3[axis]); };
    const double azimuth = (-70 + 140 * place(0)) * kDegree;
    const double height = (10 + 38 * place(1)) * kDegree;
    const double distance = 4.9 + 1.8 * place(2);
    const dvec3 target(0.3 * (uniform(random) - 0.5), 0.3 * (uniform(random) - 0.5),
                       0.45 + 0.2 * (uniform(random) - 0.5));
    const dvec3 direction(std::sin(azimuth) * std::cos(height),
                          -std::cos(azimuth) * std::cos(height), std::sin(height));
    cameras.push_back(look_at(options, target + distance * direction, target));
    cameras.back().name = fmt::format("r_{:03}", i);
  }
  return cameras;
}

}  // namespace

CaptureCameras capture_cameras(const CaptureOptions& options) {
  Random random(options.seed);
  CaptureCameras cameras;
  cameras.train = dome(options, options.train, random);
  cameras.test = dome(options, options.test, random);
  return cameras;
}

}  // namespace fluxgs::capture
