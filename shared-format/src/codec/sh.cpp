#include "codec/sh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <Eigen/Eigenvalues>

#include "codec/noise_shaping.h"

namespace fluxgs::codec {
namespace {

/// Axes of the colours along which they differ the most and the least, column by column, over all
/// coefficients in steps.
Eigen::Matrix3d color_axes(const Channels& rest) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t v = 0; v < rest.values.size() / 3; ++v) {
    Eigen::Vector3d x(rest.values[3 * v], rest.values[3 * v + 1], rest.values[3 * v + 2]);
    x /= rest.step_scale_of(3 * v / rest.channels);
    covariance += x * x.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
}

class ShQuantizer {
 public:
  ShQuantizer(const Channels& rest, std::span<const float> factors, float step,
              const RateDistortion& rate_distortion, std::span<const float> dc)
      : rest_(rest),
        factors_(factors),
        step_(step),
        rate_distortion_(rate_distortion),
        dc_(dc),
        axes_(color_axes(rest)),
        functions_(rest.channels / 3 + 1),
        shaped_(std::vector<std::uint8_t>(rest.channels), rest.splats(),
                rate_distortion.rate_weight) {}

  /// Integers for all coefficients; `dc` becomes what goes best with them.
  Expected<void> run(std::vector<float>& dc) {
    return shaped_.run([&]() -> Expected<void> {
      for (std::size_t i = 0; i < rest_.splats(); ++i)
        if (auto ok = round(i, &dc[3 * i]); !ok) return ok;
      return {};
    });
  }

  void put(Bytes& out) && {
    const Eigen::Matrix3f axes = axes_.cast<float>();
    const Layout layout{.step = step_,
                        .axes = {axes.data(), axes.data() + 9},
                        .predicted = std::vector<std::uint8_t>(rest_.channels)};
    encode_whole(layout, std::move(shaped_).planes(), out);
  }

 private:
  Expected<void> round(std::size_t i, float* dc) {
    Eigen::Vector3d moved = axes_.transpose() * color(&dc_[3 * i]);
    const std::size_t size = functions_ * (functions_ + 1) / 2;
    std::array<double, NoiseShapingQuantizer::kMax> x{}, errors{};
    const CoupledValues shaped{
        .x = std::span(x).first(functions_),
        .factor = factors_.subspan(i * size, size),
        .step = double{step_} * rest_.step_scale_of(i),
        .weight = rate_distortion_.weights.empty() ? 1.0 : double{rate_distortion_.weights[i]},
        .kept = 1};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 1; k < functions_; ++k)
        x[k] = axes_.col(axis).dot(color(&rest_.values[i * rest_.channels + 3 * (k - 1)]));
      const auto plane = static_cast<std::size_t>(axis);
      if (auto ok = shaped_.round(i, shaped, plane, 3, std::span(errors).first(functions_)); !ok)
        return ok;
      moved[axis] += NoiseShapingQuantizer::compensation(shaped, 0, errors);
    }
    Eigen::Map<Eigen::Vector3f>(dc, 3) = (axes_ * moved).cast<float>();
    return {};
  }

  static Eigen::Vector3d color(const float* rgb) { return {rgb[0], rgb[1], rgb[2]}; }

  const Channels& rest_;
  std::span<const float> factors_;
  float step_;
  const RateDistortion& rate_distortion_;
  std::span<const float> dc_;
  Eigen::Matrix3d axes_;
  std::size_t functions_;
  NoiseShapingQuantizer shaped_;
};

}  // namespace

Expected<void> encode_sh(const Channels& rest, std::span<const float> factors, float step,
                         const RateDistortion& rate_distortion, std::vector<float>& dc,
                         Bytes& out) {
  const std::vector<float> exact = dc;
  ShQuantizer quantizer(rest, factors, step, rate_distortion, exact);
  if (auto ok = quantizer.run(dc); !ok) return ok;
  std::move(quantizer).put(out);
  return {};
}

}  // namespace fluxgs::codec
