#include "trainer/compress/adaptive_degree.h"

#include <algorithm>
#include <cmath>

namespace fluxgs {
namespace {

double loss_at(const Unexplained& u, int degree, std::size_t i) {
  return double{u.weights[i]} * double{u.fitted.row(degree)[i]};
}

std::uint8_t min_degree(const Unexplained& u, double threshold, std::size_t i) {
  for (int degree = 0; degree < 3; ++degree)
    if (loss_at(u, degree, i) <= threshold) return static_cast<std::uint8_t>(degree);
  return 3;
}

/// A lower degree of a splat: taken from `threshold` on, at a loss of `more`.
struct Step {
  double threshold, more;
};

/// A lower degree is taken as soon as it is good enough, so a degree matters only up to the loss
/// of the one below.
void add_steps(const Unexplained& u, std::size_t i, std::vector<Step>& steps) {
  double before = 0;
  for (int degree = 2; degree >= 0; --degree) {
    const double loss = loss_at(u, degree, i);
    bool overtaken = false;
    for (int lower = 0; lower < degree; ++lower) overtaken |= loss_at(u, lower, i) <= loss;
    if (overtaken) continue;
    steps.push_back({loss, loss - before});
    before = loss;
  }
}

double channels_of(double pixels) { return 3 * std::max(pixels, 1.0); }

}  // namespace

std::vector<std::uint8_t> min_degrees(const Unexplained& unexplained, double threshold) {
  std::vector<std::uint8_t> degrees(unexplained.weights.size());
  for (std::size_t i = 0; i < degrees.size(); ++i)
    degrees[i] = min_degree(unexplained, threshold, i);
  return degrees;
}

double degree_loss(const Unexplained& unexplained, const std::vector<std::uint8_t>& degrees,
                   double pixels) {
  double sum = 0;
  for (std::size_t i = 0; i < degrees.size(); ++i) sum += loss_at(unexplained, degrees[i], i);
  return sum / channels_of(pixels);
}

double threshold_for(const Unexplained& unexplained, double pixels, double mse) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < unexplained.weights.size(); ++i) add_steps(unexplained, i, steps);
  std::ranges::stable_sort(steps, {}, &Step::threshold);
  const double allowed = mse * channels_of(pixels);
  double sum = 0, threshold = 0;
  for (std::size_t s = 0; s < steps.size();) {
    // Splats with the same loss go together
    const double next = steps[s].threshold;
    for (; s < steps.size() && steps[s].threshold == next; ++s) sum += steps[s].more;
    if (!(sum <= allowed)) break;
    threshold = next;
  }
  return threshold;
}

}  // namespace fluxgs
