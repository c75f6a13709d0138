#include "codec/harmonics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

namespace fluxgs::codec {
namespace {

constexpr double kLargest = 0x1p28;
constexpr std::size_t kMostFunctions = 16;

/// Row j, column k ≤ j of a lower triangle that is stored row by row.
constexpr std::size_t entry(std::size_t j, std::size_t k) { return j * (j + 1) / 2 + k; }

/// Axes of the colours along which they differ the most and the least, column by column, over all
/// coefficients in steps.
Eigen::Matrix3d color_axes(const Channels& rest) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t v = 0; v < rest.values.size() / 3; ++v) {
    Eigen::Vector3d x(rest.values[3 * v], rest.values[3 * v + 1], rest.values[3 * v + 2]);
    if (!rest.coarseness.empty()) x /= double{rest.coarseness[3 * v / rest.channels]};
    covariance += x * x.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
}

class HarmonicsRounder {
 public:
  HarmonicsRounder(const Channels& rest, std::span<const float> factors, float step,
                   const Rounding& rounding, std::span<const float> dc)
      : rest_(rest),
        factors_(factors),
        step_(step),
        rounding_(rounding),
        dc_(dc),
        axes_(color_axes(rest)),
        functions_(rest.channels / 3 + 1),
        planes_(rest.channels, std::vector<std::int32_t>(rest.splats())) {}

  /// Whole numbers for all coefficients; `dc` becomes what goes best with them.
  Expected<void> run(std::vector<float>& dc) {
    if (auto ok = pass(dc); !ok) return ok;
    if (rounding_.rate_weight <= 0) return {};
    for (int k = 0; k < kRoundingPasses; ++k) {
      prices_.clear();
      for (const auto& plane : planes_) prices_.emplace_back(plane);
      if (auto ok = pass(dc); !ok) return ok;
    }
    return {};
  }

  Triples triples() && {
    Triples result{.planes = std::move(planes_)};
    const Eigen::Matrix3f axes = axes_.cast<float>();
    std::copy_n(axes.data(), 9, result.axes.begin());
    return result;
  }

 private:
  Expected<void> pass(std::vector<float>& dc) {
    for (std::size_t i = 0; i < rest_.splats(); ++i) {
      const Eigen::Vector3d own(dc_[3 * i], dc_[3 * i + 1], dc_[3 * i + 2]);
      Eigen::Vector3d moved = axes_.transpose() * own;
      for (Eigen::Index c = 0; c < 3; ++c) {
        const auto by = round(i, static_cast<std::size_t>(c));
        if (!by)
          return fail(
              "", "",
              fmt::format("splat {}: a value over the step of {:g} is not within ±2²⁸", i, step_));
        moved[c] += *by;
      }
      moved = axes_ * moved;
      for (Eigen::Index c = 0; c < 3; ++c)
        dc[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(moved[c]);
    }
    return {};
  }

  /// Rounds one colour of splat i; by how much its constant coefficient should move, or nothing
  /// where the numbers are too large.
  std::optional<double> round(std::size_t i, std::size_t color) {
    const std::size_t size = entry(functions_, 0);
    const std::span<const float> factor = factors_.subspan(i * size, size);
    const double step =
        double{step_} * (rest_.coarseness.empty() ? 1.0 : double{rest_.coarseness[i]});
    const double weight = rounding_.weights.empty() ? 1.0 : double{rounding_.weights[i]};
    std::array<double, kMostFunctions> errors{};
    const auto made_up = [&](std::size_t k) {
      double sum = 0;
      for (std::size_t j = k + 1; j < functions_; ++j)
        sum += double{factor[entry(j, k)]} * errors[j];
      return sum / double{factor[entry(k, k)]};
    };
    for (std::size_t k = functions_ - 1; k > 0; --k) {
      const double x = value(i, k, color);
      const double z = (x + made_up(k)) / step;
      if (!(std::abs(z) < kLargest)) return {};
      const double diagonal = factor[entry(k, k)];
      const std::size_t plane = 3 * (k - 1) + color;
      const std::int32_t number = choose(z, weight * diagonal * diagonal, plane);
      planes_[plane][i] = number;
      errors[k] = x - number * step;
    }
    return made_up(0);
  }

  /// Along an axis of the colours.
  double value(std::size_t i, std::size_t function, std::size_t color) const {
    const float* rgb = &rest_.values[i * rest_.channels + 3 * (function - 1)];
    double sum = 0;
    for (Eigen::Index c = 0; c < 3; ++c)
      sum += axes_(c, static_cast<Eigen::Index>(color)) * double{rgb[c]};
    return sum;
  }

  /// The best number from the nearest to zero: where errors are made up for, it may be far from
  /// both.
  std::int32_t choose(double z, double weight, std::size_t plane) const {
    const auto near = static_cast<std::int32_t>(std::lround(z));
    if (near == 0 || prices_.empty() || !Prices::knows(near)) return near;
    const auto error = [&](std::int32_t n) { return weight * (z - n) * (z - n); };
    const auto bits = [&](std::int32_t n) { return rounding_.rate_weight * prices_[plane](n); };
    std::int32_t best = near;
    double least = error(near) + bits(near);
    for (std::int32_t n = near; n != 0 && error(n) < least;) {
      n += near > 0 ? -1 : 1;
      if (const double cost = error(n) + bits(n); cost < least) least = cost, best = n;
    }
    return best;
  }

  const Channels& rest_;
  std::span<const float> factors_;
  float step_;
  const Rounding& rounding_;
  std::span<const float> dc_;
  Eigen::Matrix3d axes_;
  std::size_t functions_;
  std::vector<Prices> prices_;  ///< by plane; empty: the nearest is taken
  std::vector<std::vector<std::int32_t>> planes_;
};

}  // namespace

Expected<void> encode_harmonics(const Channels& rest, std::span<const float> factors, float step,
                                const Rounding& rounding, std::vector<float>& dc, Bytes& out) {
  const std::vector<float> exact = dc;
  HarmonicsRounder rounder(rest, factors, step, rounding, exact);
  if (auto ok = rounder.run(dc); !ok) return ok;
  encode_triples(std::move(rounder).triples(), step, out);
  return {};
}

}  // namespace fluxgs::codec
