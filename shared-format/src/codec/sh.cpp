#include "codec/sh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <Eigen/Eigenvalues>

#include "codec/shaped_rounding.h"

namespace fluxgs::codec {
namespace {

/// Axes of the colours along which they differ the most and the least, column by column, over all
/// coefficients in steps.
Eigen::Matrix3d color_axes(const Channels& rest) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t v = 0; v < rest.values.size() / 3; ++v) {
    Eigen::Vector3d x(rest.values[3 * v], rest.values[3 * v + 1], rest.values[3 * v + 2]);
    x /= rest.coarseness_of(3 * v / rest.channels);
    covariance += x * x.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
}

class ShRounder {
 public:
  ShRounder(const Channels& rest, std::span<const float> factors, float step,
            const Rounding& rounding, std::span<const float> dc)
      : rest_(rest),
        factors_(factors),
        step_(step),
        rounding_(rounding),
        dc_(dc),
        axes_(color_axes(rest)),
        functions_(rest.channels / 3 + 1),
        shaped_(std::vector<std::uint8_t>(rest.channels), rest.splats(), rounding.rate_weight) {}

  /// Whole numbers for all coefficients; `dc` becomes what goes best with them.
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
    std::array<double, ShapedRounding::kMax> x{}, errors{};
    const Shaped shaped{.x = std::span(x).first(functions_),
                        .factor = factors_.subspan(i * size, size),
                        .step = double{step_} * rest_.coarseness_of(i),
                        .weight = rounding_.weights.empty() ? 1.0 : double{rounding_.weights[i]},
                        .kept = 1};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 1; k < functions_; ++k)
        x[k] = axes_.col(axis).dot(color(&rest_.values[i * rest_.channels + 3 * (k - 1)]));
      const auto plane = static_cast<std::size_t>(axis);
      if (auto ok = shaped_.round(i, shaped, plane, 3, std::span(errors).first(functions_)); !ok)
        return ok;
      moved[axis] += ShapedRounding::made_up(shaped, 0, errors);
    }
    Eigen::Map<Eigen::Vector3f>(dc, 3) = (axes_ * moved).cast<float>();
    return {};
  }

  static Eigen::Vector3d color(const float* rgb) { return {rgb[0], rgb[1], rgb[2]}; }

  const Channels& rest_;
  std::span<const float> factors_;
  float step_;
  const Rounding& rounding_;
  std::span<const float> dc_;
  Eigen::Matrix3d axes_;
  std::size_t functions_;
  ShapedRounding shaped_;
};

}  // namespace

Expected<void> encode_sh(const Channels& rest, std::span<const float> factors, float step,
                         const Rounding& rounding, std::vector<float>& dc, Bytes& out) {
  const std::vector<float> exact = dc;
  ShRounder rounder(rest, factors, step, rounding, exact);
  if (auto ok = rounder.run(dc); !ok) return ok;
  std::move(rounder).put(out);
  return {};
}

}  // namespace fluxgs::codec
