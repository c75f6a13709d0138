#include "codec/importance.h"

#include <algorithm>
#include <cmath>

#include "io/activation.h"

namespace fluxgs::codec {
namespace {

// Measured on scenes trained from photos and on scans: with these, the same picture takes 1 to 2.5
// bits a splat less for each of rotation, constant colour and the other harmonics; other exponents
// within ±0.1 change little.
constexpr double kRatioExponent = 0.5, kSizeExponent = 0.25, kColorExponent = 0.25;
constexpr double kUsualRatio = 2.5;  // of the logarithms of the largest and the smallest scale
constexpr double kFar = 4;           // logarithms beyond the mean count no more

/// exp(−exponent·(x − mean of x)).
std::vector<float> coarseness_of(const std::vector<double>& importance, double exponent) {
  double mean = 0;
  for (const double x : importance) mean += x / static_cast<double>(importance.size());
  std::vector<float> result;
  result.reserve(importance.size());
  for (const double x : importance)
    result.push_back(static_cast<float>(std::exp(-exponent * std::clamp(x - mean, -kFar, kFar))));
  return result;
}

}  // namespace

std::vector<float> rotation_coarseness(std::span<const glm::vec3> log_scales) {
  std::vector<double> size;
  size.reserve(log_scales.size());
  for (const glm::vec3& s : log_scales)
    size.push_back((double{s.x} + double{s.y} + double{s.z}) / 3);
  std::vector<float> result = coarseness_of(size, kSizeExponent);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const glm::vec3& s = log_scales[i];
    const double ratio = double{std::max({s.x, s.y, s.z})} - double{std::min({s.x, s.y, s.z})};
    result[i] *= static_cast<float>(
        std::exp(-kRatioExponent * (std::min(ratio, kUsualRatio + kFar) - kUsualRatio)));
  }
  return result;
}

std::vector<float> color_coarseness(std::span<const glm::vec3> log_scales,
                                    std::span<const float> opacity_logits) {
  std::vector<double> cover;
  cover.reserve(log_scales.size());
  for (std::size_t i = 0; i < log_scales.size(); ++i) {
    const glm::vec3& s = log_scales[i];
    const double area = double{s.x} + double{s.y} + double{s.z} - double{std::min({s.x, s.y, s.z})};
    cover.push_back(area + std::log(std::max(double{io::sigmoid(opacity_logits[i])}, 1e-3)));
  }
  return coarseness_of(cover, kColorExponent);
}

}  // namespace fluxgs::codec
