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

/// `focal` is the focal length over the longer side.
Camera look_at(const CaptureOptions& options, const dvec3& from, const dvec3& target,
               double focal) {
  const dvec3 forward = glm::normalize(target - from);
  const dvec3 right = glm::normalize(glm::cross(forward, dvec3(0, 0, 1)));
  const dvec3 down = glm::cross(forward, right);
  Camera camera{.name = {}, .width = options.width, .height = options.height};
  camera.fx = camera.fy = focal * std::max(options.width, options.height);
  camera.cx = options.width / 2.0;
  camera.cy = options.height / 2.0;
  camera.rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.translation = -(camera.rotation * from);
  return camera;
}

constexpr double kDegree = std::numbers::pi / 180;

/// Points that cover a cube evenly: the R3 sequence (Roberts 2018) from a random offset.
class EvenPlaces {
 public:
  explicit EvenPlaces(Random& random)
      : offset_{uniform(random), uniform(random), uniform(random)} {}
  double at(int i, int axis) const {
    constexpr double kR3[] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    return fraction(offset_[axis] + i * kR3[axis]);
  }

 private:
  double offset_[3];
};

/// A number around 0 of the width `range`.
double spread(Random& random, double range) { return range * (uniform(random) - 0.5); }

/// On a dome before the scene, looking at its middle.
Camera dome(const CaptureOptions& options, const EvenPlaces& places, int i, Random& random) {
  constexpr double kFocal = 1.12;  // 48°
  const double azimuth = (-70 + 140 * places.at(i, 0)) * kDegree;
  const double height = (10 + 38 * places.at(i, 1)) * kDegree;
  const double distance = 4.9 + 1.8 * places.at(i, 2);
  const double z = 0.45 + spread(random, 0.2), y = spread(random, 0.3), x = spread(random, 0.3);
  const dvec3 target(x, y, z);
  const dvec3 direction(std::sin(azimuth) * std::cos(height), -std::cos(azimuth) * std::cos(height),
                        std::sin(height));
  return look_at(options, target + distance * direction, target, kFocal);
}

/// Somebody walks around the middle and looks at it, and every fourth time past it into the
/// distance.
Camera walk(const CaptureOptions& options, const EvenPlaces& places, int i, Random& random) {
  constexpr double kFocal = 0.9;  // 58°
  const double azimuth = 360 * kDegree * places.at(i, 0);
  const dvec3 outward(std::cos(azimuth), std::sin(azimuth), 0);
  const dvec3 from =
      (4.2 + 4.8 * places.at(i, 1)) * outward + dvec3(0, 0, 1.5 + spread(random, 0.4));
  const double aside = spread(random, 1), up = spread(random, 1);
  const dvec3 sideways(-outward.y, outward.x, 0);
  const dvec3 past = from - 10.0 * outward + 14 * aside * sideways + dvec3(0, 0, 1 + 1.5 * up);
  const dvec3 middle = 2 * aside * sideways + dvec3(0, 0, 0.7 + 0.5 * up);
  return look_at(options, from, i % 4 == 3 ? past : middle, kFocal);
}

/// Anywhere in the middle of the room, looking anywhere.
Camera inside(const CaptureOptions& options, const EvenPlaces& places, int i, Random& random) {
  constexpr double kFocal = 0.75;  // 67°
  const dvec3 from(-1.9 + 3.8 * places.at(i, 0), -1.3 + 2.6 * places.at(i, 1),
                   1.35 + spread(random, 0.5));
  const double azimuth = 360 * kDegree * places.at(i, 2);
  const dvec3 forward(std::cos(azimuth), std::sin(azimuth), -0.12 + spread(random, 0.4));
  return look_at(options, from, from + forward, kFocal);
}

/// In a plane before the wall, looking at it almost straight.
Camera facing(const CaptureOptions& options, const EvenPlaces& places, int i, Random& random) {
  constexpr double kFocal = 1.12;  // 48°
  const dvec3 from(-1.1 + 2.2 * places.at(i, 0), -3.6 + 0.4 * places.at(i, 2),
                   1.2 + 1.3 * places.at(i, 1));
  const double x = spread(random, 0.6), z = spread(random, 0.4);
  return look_at(options, from, dvec3(0.4 * from.x + x, 0, 0.6 * from.z + 0.74 + z), kFocal);
}

Camera camera_of(const CaptureOptions& options, const EvenPlaces& places, int i, Random& random) {
  switch (options.scene) {
    case SceneKind::kOutdoor:
      return walk(options, places, i, random);
    case SceneKind::kRoom:
      return inside(options, places, i, random);
    case SceneKind::kWall:
      return facing(options, places, i, random);
    case SceneKind::kSpheres:
      break;
  }
  return dome(options, places, i, random);
}

std::vector<Camera> views(const CaptureOptions& options, int count, Random& random) {
  const EvenPlaces places(random);
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    cameras.push_back(camera_of(options, places, i, random));
    cameras.back().name = fmt::format("r_{:03}", i);
  }
  return cameras;
}

}  // namespace

CaptureCameras capture_cameras(const CaptureOptions& options) {
  Random random(options.seed);
  CaptureCameras cameras;
  cameras.train = views(options, options.train, random);
  cameras.test = views(options, options.test, random);
  return cameras;
}

}  // namespace fluxgs::capture
