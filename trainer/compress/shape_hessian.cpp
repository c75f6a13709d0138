#include "trainer/compress/shape_hessian.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/io/sensitivity_weights.h"
#include "trainer/core/random.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

constexpr std::size_t kProbes = 64;  // of all views together, if they are fewer

PlanarImage random_signs(int width, int height, Random& random) {
  PlanarImage signs(width, height, 3);
  std::uint64_t bits = 0;
  for (int channel = 0; channel < 3; ++channel)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        if (x % 64 == 0) bits = random();
        signs.row(channel, y)[x] = (bits >> (x % 64) & 1) != 0 ? 1.0f : -1.0f;
      }
  return signs;
}

/// The derivative by turns e of (1, e/2)·q, where `g` is that by the quaternion q: w, x, y, z.
glm::dvec3 by_turn(const std::array<double, 4>& q, const std::array<double, 4>& g) {
  const glm::dvec3 axis(q[1], q[2], q[3]), by_axis(g[1], g[2], g[3]);
  return 0.5 * (q[0] * by_axis - g[0] * axis + glm::cross(axis, by_axis));
}

/// Sums of g·gᵀ, lower triangles.
class Squares {
 public:
  explicit Squares(std::size_t splats) : sums_(kSymmetric3 * splats) {}

  void add(std::size_t i, const glm::dvec3& g) {
    double* to = &sums_[kSymmetric3 * i];
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column <= row; ++column) *to++ += g[row] * g[column];
  }
  std::vector<float> over(double probes) const {
    constexpr double kMax = 1e30;  // whatever the gradients, they are numbers
    std::vector<float> result;
    result.reserve(sums_.size());
    for (const double sum : sums_)
      result.push_back(static_cast<float>(std::clamp(sum / probes, -kMax, kMax)));
    return result;
  }

 private:
  std::vector<double> sums_;
};

}  // namespace

ShapeHessian shape_hessian(const PlanarFloats& parameters, const std::vector<Camera>& cameras,
                           const RenderOptions& options, const Threads& threads,
                           const WorkControl& control) {
  Squares scale(parameters.size()), rotation(parameters.size());
  Profiler profiler;
  const auto rasterizer = make_cpu_rasterizer(threads, profiler);
  const PlanarFloats& gradient = rasterizer->gradient();
  const auto number = [&](const PlanarFloats& of, int row, std::size_t i) {
    return double{of.row(row)[i]};
  };
  Random random(1);
  const std::size_t probes =
      std::max(kProbes / std::max(cameras.size(), std::size_t{1}), std::size_t{1});
  ProgressCounter counter(control.progress, cameras.size());
  for (const Camera& camera : cameras) {
    if (control.stopped()) break;
    rasterizer->forward(parameters, camera, options);
    for (std::size_t probe = 0; probe < probes; ++probe) {
      rasterizer->backward(parameters, random_signs(camera.width, camera.height, random), nullptr);
      for (std::size_t i = 0; i < parameters.size(); ++i) {
        if (rasterizer->visible()[i] == 0) continue;
        glm::dvec3 g;
        for (int c = 0; c < 3; ++c) g[c] = number(gradient, row::log_scale + c, i);
        scale.add(i, g);
        std::array<double, 4> q{}, by_q{};
        for (int c = 0; c < 4; ++c) {
          const auto k = static_cast<std::size_t>(c);
          q[k] = number(parameters, row::rotation + c, i);
          by_q[k] = number(gradient, row::rotation + c, i);
        }
        rotation.add(i, by_turn(q, by_q));
      }
    }
    counter.add_one();
  }
  const auto count = static_cast<double>(probes);
  return {.scale = scale.over(count), .rotation = rotation.over(count)};
}

}  // namespace fluxgs
