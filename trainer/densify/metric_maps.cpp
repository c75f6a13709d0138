#include "trainer/densify/metric_maps.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace fluxgs {
namespace {

cv::Mat view_of(const PlanarImage& image, int channel) {
  return cv::Mat(image.height(), image.width(), CV_32F, const_cast<float*>(image.plane(channel)),
                 image.pitch() * sizeof(float));
}

/// The window of the training loss: 11×11, σ = 1.5, zero beyond the border.
cv::Mat blurred(const cv::Mat& map) {
  cv::Mat out;
  cv::GaussianBlur(map, out, cv::Size(11, 11), 1.5, 1.5, cv::BORDER_CONSTANT);
  return out;
}

/// SSIM of every window (Wang et al. 2004).
cv::Mat ssim_map(const cv::Mat& x, const cv::Mat& y) {
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  const cv::Mat mx = blurred(x), my = blurred(y), mxx = mx.mul(mx), myy = my.mul(my),
                mxy = mx.mul(my);
  const cv::Mat xx = blurred(x.mul(x)) - mxx, yy = blurred(y.mul(y)) - myy,
                xy = blurred(x.mul(y)) - mxy;
  cv::Mat numerator = (2 * mxy + kC1), denominator = (mxx + myy + kC1);
  numerator = numerator.mul(cv::Mat(2 * xy + kC2));
  denominator = denominator.mul(cv::Mat(xx + yy + kC2));
  return numerator / denominator;
}

bool counts(const Image<std::uint8_t>& used, int x, int y) {
  return used.pixels.empty() || *used.at(x, y) != 0;
}

float unit_of(const PlanarImage& loss, ScoreUnit unit, const Image<std::uint8_t>& used) {
  if (unit == ScoreUnit::raw) return 1;
  std::vector<float> values;
  for (int y = 0; y < loss.height(); ++y)
    for (int x = 0; x < loss.width(); ++x)
      if (counts(used, x, y) && std::isfinite(loss.row(0, y)[x]))
        values.push_back(loss.row(0, y)[x]);
  if (values.empty()) return kMinUnit;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return std::max(*at, kMinUnit);
}

}  // namespace

PlanarImage loss_map(const PlanarImage& color, const PlanarImage& target, ScoreLoss loss,
                     double lambda_dssim) {
  PlanarImage out(color.width(), color.height(), 1);
  cv::Mat total = view_of(out, 0);
  const double lambda = loss == ScoreLoss::l1 ? 0 : lambda_dssim;
  for (int c = 0; c < 3; ++c) {
    const cv::Mat x = view_of(color, c), y = view_of(target, c);
    total += cv::Mat(cv::abs(x - y)) * ((1 - lambda) / 3);
    if (lambda > 0) total += (1 - ssim_map(x, y)) * (lambda / 3);
  }
  return out;
}

PlanarImage metric_maps(const PlanarImage& loss, const ScoreOptions& options,
                        const Image<std::uint8_t>& used) {
  const float unit = unit_of(loss, options.unit, used);
  const float bad = unit * static_cast<float>(options.tau_plus),
              good = unit * static_cast<float>(options.tau_minus);
  PlanarImage maps(loss.width(), loss.height(), used.pixels.empty() ? 2 : 3);
  if (!used.pixels.empty()) copy_mask(used, maps, 2);
  for (int y = 0; y < loss.height(); ++y)
    for (int x = 0; x < loss.width(); ++x) {
      if (!counts(used, x, y)) continue;
      const float l = loss.row(0, y)[x];
      maps.row(0, y)[x] = l <= bad ? 0.0f : 1.0f;
      maps.row(1, y)[x] = l < good ? std::max(l, 0.0f) : 0.0f;
    }
  return maps;
}

}  // namespace fluxgs
