#include "tools/fluxgs/commands/conversion_losses.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "fluxgs/math/logistic.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "tools/fluxgs/commands/inner_box.h"

namespace fluxgs::cli {
namespace {

std::string words_of(const ScreenFilter& filter) {
  return fmt::format("a blur of {:.3g} px², {}", filter.dilation,
                     filter.compensated ? "antialiased" : "classic");
}

/// Covariance relative to the largest axis of a splat, whose logarithm is `unit`.
glm::dmat3 covariance(const SplatCloud& cloud, std::size_t i, double unit) {
  glm::dquat q(cloud.rotations[i]);
  const double length = glm::length(q);
  q = length > 0 ? q / length : glm::dquat(1, 0, 0, 0);
  glm::dmat3 axes = glm::mat3_cast(q);
  for (int c = 0; c < 3; ++c) axes[c] *= std::exp(double{cloud.log_scales[i][c]} - unit);
  return axes * glm::transpose(axes);
}

double shape_error(const SplatCloud& a, std::size_t i, const SplatCloud& b, std::size_t k) {
  const glm::vec3& s = a.log_scales[i];
  const double unit = std::max({s.x, s.y, s.z});
  const glm::dmat3 off = covariance(a, i, unit) - covariance(b, k, unit);
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += glm::dot(off[c], off[c]);
  return std::sqrt(sum) / 2;  // of a length, half that of its square
}

struct Errors {
  std::size_t lost_shapes = 0;  // splats
  double position = 0, shape = 0, opacity = 0, colour = 0, sh = 0;
};

double largest(const glm::vec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

void raise(Errors& worst, const SplatCloud& a, std::size_t i, const SplatCloud& b, std::size_t k) {
  const auto to = [](double& value, double error) { value = std::max(value, error); };
  to(worst.position, glm::distance(glm::dvec3(a.positions[i]), glm::dvec3(b.positions[k])));
  const double shape = shape_error(a, i, b, k);
  if (shape > 1)
    ++worst.lost_shapes;
  else
    to(worst.shape, shape);
  to(worst.opacity,
     std::abs(sigmoid(double{a.opacity_logits[i]}) - sigmoid(double{b.opacity_logits[k]})));
  to(worst.colour, math::kSh0 * double{largest(a.sh_dc[i] - b.sh_dc[k])});
  const auto stride_a = static_cast<std::size_t>(sh_rest_count(a.sh_degree));
  const auto stride_b = static_cast<std::size_t>(sh_rest_count(b.sh_degree));
  for (std::size_t n = 0; n < std::min(stride_a, stride_b); ++n)
    to(worst.sh, largest(a.sh_rest[i * stride_a + n] - b.sh_rest[k * stride_b + n]));
}

double extent_of(const SplatCloud& cloud) {
  const Box box = inner_box(cloud);
  return glm::distance(box.min, box.max);
}

/// True unless half of the splats are far from where they were.
bool same_order(const SplatCloud& a, const SplatCloud& b, std::span<const std::uint32_t> order) {
  std::size_t far = 0;
  const double limit = 0.02 * extent_of(a);
  for (std::size_t k = 0; k < b.size(); ++k)
    far += glm::distance(glm::dvec3(a.positions[order.empty() ? k : order[k]]),
                         glm::dvec3(b.positions[k])) > limit;
  return 2 * far <= b.size();
}

}  // namespace

std::vector<std::string> lost_parts(const SceneFile& scene, const SceneFile& written) {
  std::vector<std::string> lost;
  if (written.cloud.size() != scene.cloud.size())
    lost.push_back(fmt::format("holds {} of {} splats", written.cloud.size(), scene.cloud.size()));
  if (written.cloud.filter != scene.cloud.filter)
    lost.push_back(fmt::format("the scene's screen filter ({}) is left out; others draw it with {}",
                               words_of(scene.cloud.filter), words_of(written.cloud.filter)));
  if (scene.start && !written.start)
    lost.emplace_back("the scene's start view and up are left out; only .glb and .ply hold them");
  return lost;
}

RoundingErrors rounding_errors(const SceneFile& scene, const SceneFile& written,
                               std::span<const std::uint32_t> order) {
  const SplatCloud &a = scene.cloud, &b = written.cloud;
  if (a.size() == 0 || a.size() != b.size()) return {};
  if (!order.empty() && order.size() != b.size()) return {};
  if (!same_order(a, b, order)) return {.text = "in another order, errors not compared"};
  Errors worst;
  for (std::size_t k = 0; k < b.size(); ++k) raise(worst, a, order.empty() ? k : order[k], b, k);
  std::vector<std::string> parts;
  constexpr double kFloat = 4e-6;  // what is above is not the rounding of floats
  if (worst.position > kFloat * std::max(extent_of(a), 1e-30))
    parts.push_back(fmt::format("positions {:.2g}", worst.position));
  if (worst.lost_shapes > 0)
    parts.push_back(fmt::format("{} shapes by more than their size", worst.lost_shapes));
  else if (worst.shape > 10 * kFloat)
    parts.push_back(fmt::format("shapes {:.2g} %", 100 * worst.shape));
  if (worst.opacity > kFloat) parts.push_back(fmt::format("opacities {:.2g}", worst.opacity));
  if (worst.colour > kFloat) parts.push_back(fmt::format("colours {:.2g}", worst.colour));
  if (worst.sh > kFloat) parts.push_back(fmt::format("SH coefficients {:.2g}", worst.sh));
  if (parts.empty()) return {};
  return {.text = fmt::format("rounded, at most: {}", fmt::join(parts, ", ")),
          .lost_shapes = worst.lost_shapes};
}

}  // namespace fluxgs::cli
