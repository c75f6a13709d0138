// Quantization of SH colours, weighted by what views see of them.
#include "codec/sh.h"
#include "fluxgs/byte_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>

#include <Eigen/Cholesky>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "fluxgs/splat_degree.h"

namespace fluxgs::codec {
namespace {

using Vector = Eigen::Matrix<double, 16, 1>;
using Matrix = Eigen::Matrix<double, 16, 16>;
using Colors = Eigen::Matrix<double, 16, 3>;

Vector basis_at(const Eigen::Vector3d& d) {
  Vector y;
  y[0] = math::kSh0;
  math::sh_basis(3, math::Vec3<double>{d.x(), d.y(), d.z()}, y.data() + 1);
  return y;
}

/// Splats of degree 3 whose higher coefficients are smaller, each seen from a few directions that
/// lie close together.
struct Splats {
  std::vector<Colors> colors;
  std::vector<Matrix> grams;  ///< over the directions, and a little over the sphere
};

Splats some_splats(std::size_t count, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Splats splats;
  for (std::size_t i = 0; i < count; ++i) {
    Colors c;
    for (int k = 0; k < 16; ++k) {
      const double grey = normal(random), size = 0.6 / (1 + std::sqrt(k));
      for (int channel = 0; channel < 3; ++channel)
        c(k, channel) = size * (grey + 0.3 * normal(random));
    }
    const Eigen::Vector3d toward(normal(random), normal(random), normal(random));
    constexpr int kViews = 20;
    Matrix gram = 1e-3 / (4 * std::numbers::pi) * Matrix::Identity();
    for (int v = 0; v < kViews; ++v) {
      const Eigen::Vector3d off(normal(random), normal(random), normal(random));
      const Vector y = basis_at((toward.normalized() + 0.3 * off).normalized());
      gram += y * y.transpose() / kViews;
    }
    splats.colors.push_back(c);
    splats.grams.push_back(gram);
  }
  return splats;
}

/// Lower triangles, row by row, up to `functions` functions.
std::vector<float> factors_of(const Splats& splats, int functions = 16) {
  std::vector<float> factors;
  for (const Matrix& gram : splats.grams) {
    const Matrix factor = (4 * std::numbers::pi * gram).llt().matrixL();
    for (int row = 0; row < functions; ++row)
      for (int column = 0; column <= row; ++column)
        factors.push_back(static_cast<float>(factor(row, column)));
  }
  return factors;
}

std::vector<float> identity_factors(std::size_t splats) {
  std::vector<float> factors;
  for (std::size_t i = 0; i < splats; ++i)
    for (int row = 0; row < 16; ++row)
      for (int column = 0; column <= row; ++column) factors.push_back(row == column ? 1.0f : 0.0f);
  return factors;
}

std::vector<float> rows(const Splats& splats, int from, int until) {
  std::vector<float> values;
  for (const Colors& c : splats.colors)
    for (int k = from; k < until; ++k)
      for (int channel = 0; channel < 3; ++channel)
        values.push_back(static_cast<float>(c(k, channel)));
  return values;
}

struct Quantized {
  std::vector<Colors> colors;
  std::size_t bytes = 0;
};

Quantized rounded(const Splats& splats, const std::vector<float>& factors, float step,
                  double rate_weight, std::vector<float> step_scale = {}) {
  const std::size_t n = splats.colors.size();
  const Channels rest{45, rows(splats, 1, 16), std::move(step_scale)};
  std::vector<float> dc = rows(splats, 0, 1);
  Bytes bytes;
  const auto done = encode_sh(rest, factors, step, {.rate_weight = rate_weight}, dc, bytes);
  EXPECT_TRUE(done) << done.error().message();
  std::vector<float> planes(rest.values.size());
  ByteReader in(bytes);
  const auto decoded = decode_channels(in, 45, rest.step_scale, planes);
  EXPECT_TRUE(decoded) << decoded.error().message();
  EXPECT_EQ(in.left(), 0u);
  Quantized result{std::vector<Colors>(n), bytes.size()};
  for (std::size_t i = 0; i < n; ++i)
    for (int channel = 0; channel < 3; ++channel) {
      const auto c = static_cast<std::size_t>(channel);
      result.colors[i](0, channel) = double{dc[3 * i + c]};
      for (std::size_t k = 0; k < 15; ++k)
        result.colors[i](static_cast<int>(k) + 1, channel) = double{planes[(3 * k + c) * n + i]};
    }
  return result;
}

/// (4π)·Σ eᵀ·G·e over the channels.
double seen_error(const Matrix& gram, const Colors& a, const Colors& b) {
  const Colors e = a - b;
  return 4 * std::numbers::pi * (e.transpose() * gram * e).trace();
}

double mean_seen_error(const Splats& splats, const std::vector<Colors>& to) {
  double sum = 0;
  for (std::size_t i = 0; i < to.size(); ++i)
    sum += seen_error(splats.grams[i], splats.colors[i], to[i]);
  return sum / static_cast<double>(to.size());
}

// The bound of Babai's nearest plane: (step/2)²·Σ L_kk² for each colour, and nothing for the
// constant coefficient, which is not rounded here.
TEST(Sh, ErrorsThatViewsSeeAreWithinTheBound) {
  const Splats splats = some_splats(300);
  std::vector<float> step_scale(300);
  for (std::size_t i = 0; i < step_scale.size(); ++i)
    step_scale[i] = 0.5f + 0.01f * static_cast<float>(i);
  const float step = 0.2f;
  const Quantized r = rounded(splats, factors_of(splats), step, 0, step_scale);
  for (std::size_t i = 0; i < 300; ++i) {
    const Matrix factor = (4 * std::numbers::pi * splats.grams[i]).llt().matrixL();
    const double half = 0.5 * double{step} * double{step_scale[i]};
    const double bound =
        3 * half * half * (factor.diagonal().squaredNorm() - factor(0, 0) * factor(0, 0));
    EXPECT_LE(seen_error(splats.grams[i], splats.colors[i], r.colors[i]), 1.001 * bound) << i;
  }
}

TEST(Sh, SeenFromAllSidesTheyAreRoundedToTheNearest) {
  const Splats splats = some_splats(200);
  const float step = 0.1f;
  const Quantized r = rounded(splats, identity_factors(200), step, 0);
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_LT((r.colors[i].row(0) - splats.colors[i].row(0)).norm(), 1e-6);
    // Along the axes of the colours, by half a step each
    for (int k = 1; k < 16; ++k)
      EXPECT_LE((r.colors[i].row(k) - splats.colors[i].row(k)).norm(),
                0.5 * double{step} * std::sqrt(3) + 1e-5);
  }
}

TEST(Sh, FewerBytesLoseLess) {
  const Splats splats = some_splats(4000);
  const Quantized shaped = rounded(splats, factors_of(splats), 0.15f, kDefaultRateWeight);
  const Quantized blind = rounded(splats, identity_factors(4000), 0.2f, kDefaultRateWeight);
  EXPECT_LT(shaped.bytes, blind.bytes);  // 17,600, 21,000
  EXPECT_LT(mean_seen_error(splats, shaped.colors), mean_seen_error(splats, blind.colors) / 4);
}

TEST(Sh, BitsThatAreNotWorthTheirErrorAreSaved) {
  const Splats splats = some_splats(2000);
  const auto factors = factors_of(splats);
  const Quantized nearest = rounded(splats, factors, 0.1f, 0);
  const Quantized cheap = rounded(splats, factors, 0.1f, 0.115);
  const Quantized cheaper = rounded(splats, factors, 0.1f, 1);
  EXPECT_LT(static_cast<double>(cheap.bytes), 0.9 * static_cast<double>(nearest.bytes));
  EXPECT_LT(static_cast<double>(cheaper.bytes), 0.8 * static_cast<double>(cheap.bytes));
  EXPECT_LT(mean_seen_error(splats, nearest.colors), mean_seen_error(splats, cheap.colors));
  EXPECT_LT(mean_seen_error(splats, cheap.colors), mean_seen_error(splats, cheaper.colors));
}

TEST(Sh, NumbersBeyondTheirReachAreRefused) {
  Splats splats = some_splats(3);
  splats.colors[1](5, 2) = 1e12;
  std::vector<float> dc = rows(splats, 0, 1);
  Bytes bytes;
  const auto done =
      encode_sh({45, rows(splats, 1, 16), {}}, factors_of(splats), 1e-3f, {}, dc, bytes);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message().find("splat 1"), std::string::npos) << done.error().message();
}

TEST(WholeNumbers, DamageIsRefused) {
  const Layout layout{.step = 0.5f, .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .predicted = {0, 0, 0}};
  std::vector<std::vector<std::int32_t>> planes = {{1, 2, 3}, {4, 5, -6}, {7, 0, 0}};
  Bytes good;
  encode_whole(layout, planes, good);
  const auto decode = [](const Bytes& bytes, std::size_t channels) {
    ByteReader in(bytes);
    std::vector<float> back(3 * channels);
    return decode_channels(in, channels, {}, back).has_value() && in.left() == 0;
  };
  EXPECT_TRUE(decode(good, 3));
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(decode(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)), 3))
        << size;
  Bytes bad = good;
  bad[1] = std::byte{3};  // a kind of header that there is not
  EXPECT_FALSE(decode(bad, 3));
  planes.pop_back();  // channels that are no triples
  Bytes two;
  encode_whole(layout, planes, two);
  EXPECT_FALSE(decode(two, 2));
}

/// The splats as a scene, the first of them up to degrees 1 and 2 only.
SplatCloud cloud_of(const Splats& splats) {
  SplatCloud cloud;
  cloud.sh_degree = 3;
  cloud.resize(splats.colors.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto n = static_cast<float>(i);
    cloud.positions[i] = {std::sin(n), std::cos(1.7f * n), std::sin(0.3f * n)};
    cloud.log_scales[i] = glm::vec3(-3);
    cloud.rotations[i] = glm::quat(1, 0, 0, 0);
    const auto color = [&](int k) {
      return glm::vec3(splats.colors[i](k, 0), splats.colors[i](k, 1), splats.colors[i](k, 2));
    };
    cloud.sh_dc[i] = color(0);
    const int degree = static_cast<int>(1 + i % 3);
    for (int k = 0; k < sh_rest_count(degree); ++k)
      cloud.sh_rest[15 * i + static_cast<std::size_t>(k)] = color(k + 1);
  }
  return cloud;
}

/// Of a file's colours, over the directions.
double error_of_file(const Splats& splats, const SplatCloud& cloud, const CompactOptions& options) {
  const auto file = encode_compact_glb(cloud, options, "x.glb");
  EXPECT_TRUE(file) << file.error().message();
  const auto scene = read_glb(*file, "x.glb");
  EXPECT_TRUE(scene) << scene.error().message();
  const std::vector<std::uint32_t> order = compact_order(cloud);
  const auto color = [](const SplatCloud& from, std::size_t i) {
    Colors c;
    for (int k = 0; k < 16; ++k)
      for (int channel = 0; channel < 3; ++channel)
        c(k, channel) =
            double{(k == 0 ? from.sh_dc[i]
                           : from.sh_rest[15 * i + static_cast<std::size_t>(k) - 1])[channel]};
    return c;
  };
  double sum = 0;
  for (std::size_t k = 0; k < order.size(); ++k)
    sum += seen_error(splats.grams[order[k]], color(scene->cloud, k), color(cloud, order[k]));
  return sum;
}

// Through the file: its frame is another, splats of each degree are a part, and NaN is left out.
TEST(Sh, FilesKeepWhatViewsSee) {
  const Splats splats = some_splats(3 * 700);
  const SplatCloud cloud = cloud_of(splats);
  CompactOptions options{.steps = {.sh_dc = 0.01f, .sh_rest = 0.2f}};
  const double blind = error_of_file(splats, cloud, options);
  options.sensitivity.sh_factors = factors_of(splats);
  EXPECT_LT(error_of_file(splats, cloud, options), blind / 3);
}

TEST(Sh, FactorsThatDoNotFitAreNamed) {
  const SplatCloud cloud = cloud_of(some_splats(20));
  CompactOptions options{.sensitivity = {.sh_factors = {1, 2}}};
  const auto error = [&] {
    const auto file = encode_compact_glb(cloud, options, "x.glb");
    return file ? "" : file.error().message();
  };
  EXPECT_EQ(error(),
            "x.glb: factors of SH coefficients: 2 values, expected 136 for each of 20 splats");
  options.sensitivity.sh_factors = identity_factors(20);
  EXPECT_EQ(error(), "");
  options.sensitivity.sh_factors[3 * 136 + 5] = 0;
  EXPECT_EQ(
      error(),
      "x.glb: factors of SH coefficients: splat 3 has 0 on its diagonal, expected more than 0");
  options.sensitivity.sh_factors = identity_factors(20);
  options.sensitivity.sh_factors[4] = NAN;
  EXPECT_EQ(error(), "x.glb: factors of SH coefficients: have a value that is not finite");
  SplatCloud hole = cloud;
  hole.positions[7].x = NAN;  // left out with its factors
  options.sensitivity.sh_factors = identity_factors(20);
  EXPECT_TRUE(encode_compact_glb(hole, options, "x.glb"));
}

}  // namespace
}  // namespace fluxgs::codec
