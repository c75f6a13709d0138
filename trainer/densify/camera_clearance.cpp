#include "trainer/densify/camera_clearance.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

constexpr std::size_t kClearancePiece = 1024;  // splats
constexpr double kLeastFactor = 0.25;          // of a size, at a time

/// The least squared distance of cameras from splat i in its standard deviations, or `most`.
double squared_clearance(const PlanarFloats& parameters, std::size_t i,
                         const std::vector<glm::dvec3>& cameras, double most) {
  const auto three = [&](int first) {
    const auto at = [&](int c) { return double{parameters.row(first + c)[i]}; };
    return glm::dvec3(at(0), at(1), at(2));
  };
  const glm::dvec3 center = three(row::position), scale = glm::exp(three(row::log_scale));
  const double largest = std::max({scale.x, scale.y, scale.z});
  const double reach = most * largest * largest;
  const glm::dquat to_own = glm::conjugate(glm::normalize(rotation_of(parameters, i)));
  double least = most;
  for (const glm::dvec3& camera : cameras) {
    const glm::dvec3 offset = camera - center;
    if (glm::dot(offset, offset) >= reach) continue;
    const glm::dvec3 own = to_own * offset / scale;
    least = std::min(least, glm::dot(own, own));
  }
  return least;
}

class CameraClearance final : public Phase {
 public:
  CameraClearance(const CameraClearanceOptions& options, int iterations)
      : clearance_(options.clearance), iterations_(iterations) {}

  const char* name() const override { return "camera clearance"; }
  /// Later there is room for the values of the file.
  Period period() const override {
    return {.from = 1, .until = iterations_ / 5 * 4, .interval = 100};
  }
  std::string effect() const override {
    return fmt::format("makes splats smaller that have a camera within {:g} standard deviations",
                       clearance_);
  }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (!period().due(t.state.iteration)) return {};
    std::vector<glm::dvec3> cameras;
    for (const View& view : t.data.train) cameras.push_back(view.camera.center());
    clear_cameras(cameras, clearance_, t.state.parameters, t.threads);
    return {};
  }

 private:
  double clearance_;
  int iterations_;
};

}  // namespace

OptionFields CameraClearanceOptions::fields(const TrainOptions&) {
  return {real("camera-clearance",
               "standard deviations that a splat keeps from every camera (0: off)", clearance, 0,
               100)};
}

void clear_cameras(const std::vector<glm::dvec3>& cameras, double clearance,
                   PlanarFloats& parameters, const Threads& threads) {
  const double wanted = clearance * clearance;
  threads.for_pieces(parameters.size(), kClearancePiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double least = squared_clearance(parameters, i, cameras, wanted);
      if (least >= wanted) continue;
      const double factor = std::max(std::sqrt(least / wanted), kLeastFactor);
      for (int c = 0; c < 3; ++c)
        parameters.row(row::log_scale + c)[i] += static_cast<float>(std::log(factor));
    }
  });
}

std::unique_ptr<Phase> make_camera_clearance(const TrainOptions& options) {
  const auto& own = options.get<CameraClearanceOptions>();
  if (own.clearance <= 0) return nullptr;
  return std::make_unique<CameraClearance>(own, options.iterations);
}

}  // namespace fluxgs
