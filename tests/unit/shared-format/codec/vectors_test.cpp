// Quantization of three values a splat, weighted by the cost of their errors.
#include "codec/vectors.h"
#include "fluxgs/byte_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "codec/rotations.h"
#include "codec/stored_sensitivity.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf.h"

namespace fluxgs::codec {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kAdded = 0.15;  // kMinCost of vectors.cpp

Vector3d random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  return {x, y, normal(random)};
}

struct Splats {
  Channels input{3, {}};
  std::vector<Matrix3d> sensitivity;
};

/// A walk whose steps are about the step scale, and costs that hardly count along one direction.
Splats some_splats(std::size_t count, bool walk, unsigned seed = 1) {
  std::mt19937 random(seed);
  Splats splats;
  Vector3d x = Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    x = (walk ? x : Vector3d::Zero()) + random_vector(random);
    for (int c = 0; c < 3; ++c) splats.input.values.push_back(static_cast<float>(x[c]));
    splats.input.step_scale.push_back(0.5f + static_cast<float>(i % 7) / 6);
    const Vector3d free = random_vector(random).normalized();
    const double size = std::exp(random_vector(random).x());
    splats.sensitivity.push_back(size * (1.01 * Matrix3d::Identity() - free * free.transpose()));
  }
  return splats;
}

std::vector<float> matrices(const std::vector<Matrix3d>& matrices) {
  std::vector<float> result;
  for (const Matrix3d& m : matrices)
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column <= row; ++column)
        result.push_back(static_cast<float>(m(row, column)));
  return result;
}

Matrix3d matrix_of(const float* t) {
  Matrix3d h;
  h << double{t[0]}, double{t[1]}, double{t[3]}, double{t[1]}, double{t[2]}, double{t[4]},
      double{t[3]}, double{t[4]}, double{t[5]};
  return h;
}

struct Quantized {
  std::vector<Vector3d> errors;
  std::size_t bytes = 0;
};

Quantized rounded(const Splats& splats, const std::vector<Matrix3d>& sensitivity, float step,
                  double rate_weight) {
  Bytes bytes;
  const auto done = encode_vectors(splats.input, matrices(sensitivity), step, rate_weight, bytes);
  EXPECT_TRUE(done) << done.error().message();
  const std::size_t n = splats.input.splats();
  std::vector<float> planes(3 * n);
  ByteReader in(bytes);
  const auto decoded = decode_channels(in, 3, splats.input.step_scale, planes);
  EXPECT_TRUE(decoded) << decoded.error().message();
  EXPECT_EQ(in.left(), 0u);
  Quantized result{.errors = {}, .bytes = bytes.size()};
  for (std::size_t i = 0; i < n; ++i) {
    Vector3d e;
    for (std::size_t c = 0; c < 3; ++c)
      e[static_cast<int>(c)] = double{planes[c * n + i]} - double{splats.input.values[3 * i + c]};
    result.errors.push_back(e);
  }
  return result;
}

double mean_cost(const Splats& splats, const Quantized& r) {
  double sum = 0;
  for (std::size_t i = 0; i < r.errors.size(); ++i)
    sum += r.errors[i].dot(splats.sensitivity[i] * r.errors[i]);
  return sum / static_cast<double>(r.errors.size());
}

// Babai's bound of Σ (L_kk/2)², and L_kk² is at most what is on the diagonal.
TEST(Vectors, CostsAreWithinTheBound) {
  for (const bool walk : {false, true}) {
    const Splats splats = some_splats(500, walk);
    const double step = 0.25;
    double mean = 0;
    for (std::size_t i = 0; i < 500; ++i)
      mean += std::pow(splats.input.step_scale[i], 2) * splats.sensitivity[i].trace() / 1500;
    const Quantized r = rounded(splats, splats.sensitivity, static_cast<float>(step), 0);
    for (std::size_t i = 0; i < 500; ++i) {
      const double own = double{splats.input.step_scale[i]};
      const Matrix3d h = own * own / mean * splats.sensitivity[i] + kAdded * Matrix3d::Identity();
      const Vector3d e = r.errors[i] / (step * own);
      EXPECT_LE(e.dot(h * e), 0.25 * h.trace() * 1.001) << i;
    }
  }
}

TEST(Vectors, WithEqualCostsTheyAreRoundedToTheNearest) {
  const Splats splats = some_splats(300, true);
  const Quantized r = rounded(splats, std::vector<Matrix3d>(300, Matrix3d::Identity()), 0.2f, 0);
  for (std::size_t i = 0; i < 300; ++i)
    EXPECT_LE(r.errors[i].norm(),
              0.1 * double{splats.input.step_scale[i]} * std::sqrt(3) * 1.001 + 1e-5);
}

TEST(Vectors, FewerBytesCostLess) {
  const Splats splats = some_splats(4000, false);
  const std::vector<Matrix3d> blind(4000, Matrix3d::Identity());
  const Quantized a = rounded(splats, splats.sensitivity, 0.32f, kDefaultRateWeight);
  const Quantized b = rounded(splats, blind, 0.3f, kDefaultRateWeight);
  EXPECT_LT(a.bytes, b.bytes);
  EXPECT_LT(mean_cost(splats, a), 0.95 * mean_cost(splats, b));
}

TEST(Vectors, NeighboursThatAreAlikeTakeFewerBytes) {
  const Splats walk = some_splats(3000, true);
  Splats shuffled = walk;
  std::mt19937 random(3);
  for (std::size_t i = 3000; i > 1; --i) {
    const std::size_t j = random() % i;
    for (std::size_t c = 0; c < 3; ++c)
      std::swap(shuffled.input.values[3 * (i - 1) + c], shuffled.input.values[3 * j + c]);
  }
  EXPECT_LT(rounded(walk, walk.sensitivity, 0.3f, kDefaultRateWeight).bytes,
            rounded(shuffled, walk.sensitivity, 0.3f, kDefaultRateWeight).bytes * 9 / 10);
}

TEST(Vectors, CostsThatCannotBeAreNoError) {
  const Splats splats = some_splats(50, false);
  EXPECT_GT(rounded(splats, std::vector<Matrix3d>(50, Matrix3d::Zero()), 0.1f, 0.1).bytes, 0u);
  Matrix3d indefinite = Matrix3d::Identity();
  indefinite(0, 1) = indefinite(1, 0) = -50;
  const Quantized r = rounded(splats, std::vector<Matrix3d>(50, indefinite), 0.1f, 0);
  for (const Vector3d& e : r.errors) EXPECT_LT(e.norm(), 0.2);
}

TEST(Vectors, NumbersBeyondTheirReachAreRefused) {
  Splats splats = some_splats(5, false);
  splats.input.values[4] = 1e12f;
  Bytes bytes;
  const auto done = encode_vectors(splats.input, matrices(splats.sensitivity), 1e-3f, 0, bytes);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message().find("its value over the step of 0.001 is"), std::string::npos)
      << done.error().message();
}

TEST(StoredSensitivity, OfRootsAreThoseOfTheLogarithms) {
  const std::vector<Matrix3d> sensitivity = some_splats(20, false).sensitivity;
  std::vector<glm::vec3> logs;
  for (int i = 0; i < 20; ++i) logs.emplace_back(-0.1f * float(i), 0.05f * float(i), -1);
  const auto stored = sensitivity_of_roots(matrices(sensitivity), logs);
  for (std::size_t i = 0; i < 20; ++i) {
    const Vector3d moved(3e-4, -2e-4, 1e-4);
    Vector3d error;
    for (int c = 0; c < 3; ++c) {
      const double root = std::exp(double{logs[i][c]} / 2);
      error[c] = 2 * std::log1p(moved[c] / root);
    }
    EXPECT_NEAR(moved.dot(matrix_of(&stored[6 * i]) * moved) / error.dot(sensitivity[i] * error), 1,
                0.01);
  }
}

TEST(StoredSensitivity, OfRootsOfNothingAreNumbers) {
  const std::vector<glm::vec3> logs(4, glm::vec3(-300, 0, 300));
  for (const float x : sensitivity_of_roots(matrices(some_splats(4, false).sensitivity), logs))
    EXPECT_TRUE(std::isfinite(x));
}

Eigen::Quaterniond eigen(const glm::quat& q) {
  return Eigen::Quaterniond(double{q.w}, double{q.x}, double{q.y}, double{q.z}).normalized();
}

/// |e| radians about e, from a to b.
Vector3d turn_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::AngleAxisd turn(b * a.conjugate());
  return turn.angle() * turn.axis();
}

std::vector<glm::quat> random_rotations(std::size_t count) {
  std::mt19937 random(2);
  std::vector<glm::quat> rotations;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d v = random_vector(random);
    const auto w = static_cast<float>(random_vector(random).x());
    rotations.emplace_back(3 * w, 3 * float(v.x()), 3 * float(v.y()), 3 * float(v.z()));
  }
  return rotations;
}

TEST(StoredSensitivity, OfRotationsAreThoseOfTheTurn) {
  const std::vector<Matrix3d> sensitivity = some_splats(60, false).sensitivity;
  const std::vector<glm::quat> rotations = random_rotations(60);
  const auto stored = sensitivity_of_rotations(matrices(sensitivity), rotations);
  for (std::size_t i = 0; i < 60; ++i) {
    const glm::vec3 xyz = reduced_rotation(rotations[i]), by(2e-3f, -1e-3f, 1.5e-3f);
    const Vector3d error = turn_between(eigen(full_rotation(xyz)), eigen(full_rotation(xyz + by)));
    const Vector3d moved(double{by.x}, double{by.y}, double{by.z});
    EXPECT_NEAR(moved.dot(matrix_of(&stored[6 * i]) * moved) / error.dot(sensitivity[i] * error), 1,
                0.03)
        << i;
  }
}

/// A scene of long splats.
SplatCloud some_cloud(std::size_t count) {
  SplatCloud cloud;
  cloud.resize(count);
  const auto rotations = random_rotations(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto n = static_cast<float>(i);
    cloud.positions[i] = {std::sin(n), std::cos(1.7f * n), std::sin(0.3f * n)};
    cloud.log_scales[i] = glm::vec3(-3, -4, -5);
    cloud.rotations[i] = rotations[i];
    cloud.opacity_logits[i] = 2;
    cloud.sh_dc[i] = glm::vec3(0.1f * std::sin(n));
  }
  canonicalize_rotations(cloud);
  return cloud;
}

// The file's frame is another, of which turns about an axis know.
TEST(SensitivityWeights, FilesKeepTheTurnsThatCost) {
  const SplatCloud cloud = some_cloud(2000);
  const Vector3d costly = Vector3d(1, 1, 1).normalized(), other = Vector3d(-1, -1, 1).normalized();
  CompactOptions options{.steps = {.rotation = 0.1f}};
  options.sensitivity.rotation =
      matrices(std::vector<Matrix3d>(cloud.size(), costly * costly.transpose()));
  const auto file = encode_compact_glb(cloud, options, "x.glb");
  ASSERT_TRUE(file) << file.error().message();
  const auto scene = read_glb(*file, "x.glb");
  ASSERT_TRUE(scene) << scene.error().message();
  const std::vector<std::uint32_t> order = compact_order(cloud);
  double along = 0, across = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const glm::quat exact = canonical_rotation(cloud.rotations[order[k]]);
    const glm::quat stored = canonical_rotation(scene->cloud.rotations[k]);
    Eigen::Quaterniond a = eigen(exact), b = eigen(stored);
    Vector3d turn = turn_between(a, b);
    if (turn.norm() > 1) continue;  // of nearly equal candidates, rounding may pick another
    along += std::pow(turn.dot(costly), 2);
    across += std::pow(turn.dot(other), 2);
  }
  EXPECT_LT(along, 0.5 * across);
}

TEST(SensitivityWeights, WhatDoesNotFitIsNamed) {
  const SplatCloud cloud = some_cloud(20);
  CompactOptions options;
  const auto error = [&] {
    const auto file = encode_compact_glb(cloud, options, "x.glb");
    return file ? "" : file.error().message();
  };
  options.sensitivity.scale = {1, 2, 3};
  EXPECT_EQ(error(), "x.glb: costs of scales: 3 values, expected 6 for each of 20 splats");
  options.sensitivity.scale = matrices(std::vector<Matrix3d>(20, Matrix3d::Identity()));
  EXPECT_EQ(error(), "");
  options.sensitivity.scale[6 * 4 + 2] = -1;
  EXPECT_EQ(error(), "x.glb: costs of scales: splat 4 has -1 on its diagonal, expected 0 or more");
  options.sensitivity.scale[6 * 4 + 2] = INFINITY;
  EXPECT_EQ(error(), "x.glb: costs of scales: have a value that is not finite");
  options.sensitivity.scale = {};
  options.sensitivity.rotation.assign(6 * 20, NAN);
  EXPECT_EQ(error(),
            "x.glb: costs of rotations: splat 0 has nan on its diagonal, expected 0 or more");
  options.sensitivity.rotation.assign(6 * 20, 0);
  SplatCloud hole = cloud;
  hole.positions[7].x = NAN;  // left out with its costs
  EXPECT_TRUE(encode_compact_glb(hole, options, "x.glb"));
}

}  // namespace
}  // namespace fluxgs::codec
