#include "trainer/compress/scene_reduction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include "fluxgs/contribution.h"

namespace fluxgs {
namespace {

// A few hundred steps in all: second moments are those of the last hundred
const AdamConstants kAdam{.beta1 = 0.9, .beta2 = 0.99, .epsilon = 1e-15};

// The images' difference (root of the mean square, 0…1) from which on the rates of 3DGS are right.
// Steps of Adam do not shrink with the error: beside a smaller one they are made smaller.
constexpr double kFullRateError = 0.01, kLeastRate = 0.02;

LearningRates rates_of(double factor, double extent) {
  return {.position = factor * 5e-5 * extent,
          .log_scale = factor * 5e-3,
          .rotation = factor * 1e-3,
          .opacity = factor * 0.025,
          .sh_dc = factor * 2.5e-3,
          .sh_rest = factor * 1.25e-4};
}

/// Scene units; of one camera as for one at a unit's distance.
double distance_from_middle(const std::vector<Camera>& cameras) {
  glm::dvec3 middle(0);
  for (const Camera& camera : cameras) middle += camera.center();
  middle /= static_cast<double>(cameras.size());
  double most = 0;
  for (const Camera& camera : cameras)
    most = std::max(most, glm::distance(camera.center(), middle));
  return most > 0 ? most : 1;
}

/// 2·(color − target); the sum of squares is added to `sum`.
PlanarImage twice_difference(const PlanarImage& color, const PlanarImage& target, double& sum) {
  PlanarImage result(color.width(), color.height(), 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < color.height(); ++y) {
      const float *a = color.row(c, y), *b = target.row(c, y);
      float* out = result.row(c, y);
      float line = 0;
      for (int x = 0; x < color.width(); ++x) {
        const float d = a[x] - b[x];
        line += d * d;
        out[x] = 2 * d;
      }
      sum += double{line};
    }
  return result;
}

/// The target of the costs. Of many splats that would each mend an error alone, all would go at
/// once: with half of the error they lose less than with all of it (fox, 18,000 of 37,528 splats
/// without a fit: 32.9 dB instead of 25.7).
PlanarImage halfway(const PlanarImage& color, const PlanarImage& target) {
  PlanarImage result(color.width(), color.height(), 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < color.height(); ++y) {
      const float *a = color.row(c, y), *b = target.row(c, y);
      std::transform(a, a + color.width(), b, result.row(c, y),
                     [](float x, float z) { return 0.5F * (x + z); });
    }
  return result;
}

}  // namespace

SceneReduction::SceneReduction(const SplatCloud& whole, const std::vector<Camera>& cameras,
                               const ReductionOptions& options, const Threads& threads)
    : options_(options),
      threads_(threads),
      filter_(whole.filter),
      sh_degree_(whole.sh_degree),
      extent_(distance_from_middle(cameras)),
      parameters_(to_parameters(whole, whole.sh_degree)),
      adam_{PlanarFloats(parameters_.rows(), parameters_.size()),
            PlanarFloats(parameters_.rows(), parameters_.size())},
      rasterizer_(make_cpu_rasterizer(threads, profiler_)) {
  options_.render = for_scene(options.render, filter_);
  // Neighbours follow each other in a data set: what follows here sees something else
  std::vector<std::size_t> order(cameras.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto place = [](std::size_t i) {
    const double turn = static_cast<double>(i) * std::numbers::phi;
    return turn - std::floor(turn);
  };
  std::ranges::sort(order, {}, place);
  for (const std::size_t i : order) {
    rasterizer_->forward(parameters_, cameras[i], options_.render);
    targets_.push_back({cameras[i], rasterizer_->color()});
  }
}

SplatCloud SceneReduction::cloud() const {
  SplatCloud result = to_cloud(parameters_, sh_degree_);
  result.filter = filter_;
  return result;
}

void SceneReduction::fit(const PlanarImage& twice_error, double rate) {
  rasterizer_->backward(parameters_, twice_error, nullptr);
  const AdamStep step(kAdam, ++steps_, adam_kernels(best_isa()));
  adam_step(parameters_, adam_, rasterizer_->gradient(), rasterizer_->visible(),
            rates_of(rate, extent_), step, {0, parameters_.rows()}, threads_);
}

void SceneReduction::visit_one(const Target& target, const Visit& visit) {
  rasterizer_->forward(parameters_, target.camera, options_.render);
  double squares = 0;
  const PlanarImage twice_error = twice_difference(rasterizer_->color(), target.color, squares);
  squared_error_ += squares;
  values_ += 3.0 * target.camera.width * target.camera.height;
  if (visit.scores) {
    const PlanarFloats& found = rasterizer_->removal(halfway(rasterizer_->color(), target.color));
    for (std::size_t i = 0; i < size(); ++i) {
      costs_[i] += double{found.row(removal::change)[i]};
      pixels_[i] += double{found.row(removal::pixels)[i]};
    }
  }
  if (visit.rate > 0 && squares > 0) fit(twice_error, visit.rate);
}

void SceneReduction::visit_all(Visit visit, ProgressCounter& counter, const WorkControl& control) {
  costs_.assign(size(), 0);
  pixels_.assign(size(), 0);
  const double error = values_ > 0 ? std::sqrt(squared_error_ / values_) : 0;
  visit.rate *= std::clamp(error / kFullRateError, kLeastRate, 1.0);
  squared_error_ = values_ = 0;
  for (const Target& target : targets_) {
    if (control.stopped()) return;
    visit_one(target, visit);
    counter.add_one();
  }
}

void SceneReduction::keep(std::size_t count) {
  const SplatCloud now = cloud();
  std::vector<double> anywhere(size());
  for (std::size_t i = 0; i < size(); ++i) anywhere[i] = contribution(now, i);
  const auto kept = first_indices(size(), count, [&](std::uint32_t a, std::uint32_t b) {
    if ((pixels_[a] > 0) != (pixels_[b] > 0)) return pixels_[a] > 0;
    if (costs_[a] != costs_[b]) return costs_[a] > costs_[b];
    return anywhere[a] != anywhere[b] ? anywhere[a] > anywhere[b] : a < b;
  });
  parameters_ = parameters_.gather(kept);
  adam_.first = adam_.first.gather(kept);
  adam_.second = adam_.second.gather(kept);
}

void SceneReduction::reduce(std::size_t count, const WorkControl& control) {
  if (count >= size()) return;
  const auto before = static_cast<double>(size());
  const double left = static_cast<double>(count) / before;
  const double most_rounds = std::log(std::max(left, 1 / before)) / std::log1p(-options_.share);
  const int rounds = std::max(1, static_cast<int>(std::ceil(most_rounds - 1e-9)));
  const auto visits = static_cast<std::size_t>(rounds + options_.passes);
  ProgressCounter counter(control.progress, visits * targets_.size());
  for (int round = 1; round <= rounds; ++round) {
    visit_all({.scores = true, .rate = options_.passes > 0 ? 1.0 : 0.0}, counter, control);
    if (control.stopped()) return;
    const double now = before * std::pow(left, static_cast<double>(round) / rounds);
    keep(round == rounds ? count : std::max(count, static_cast<std::size_t>(now)));
  }
  for (int pass = 0; pass < options_.passes && !control.stopped(); ++pass)
    visit_all({.rate = 1 - static_cast<double>(pass) / options_.passes}, counter, control);
}

}  // namespace fluxgs
