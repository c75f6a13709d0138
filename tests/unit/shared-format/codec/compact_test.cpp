// A whole scene through the compact codec: what is lost, and what damaged bytes do.
#include "codec/compact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <string>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "codec/perceptual_weight.h"
#include "fluxgs/math/projection.h"
#include "fluxgs/morton.h"
#include "support/scenes.h"

namespace fluxgs::codec {
namespace {

/// The covariance as a sum over the splat's axes, relative to its largest entry.
glm::dmat3 shape_of(const SplatCloud& cloud, std::size_t i) {
  const glm::dmat3 r = glm::mat3_cast(glm::normalize(glm::dquat(cloud.rotations[i])));
  glm::dmat3 sum(0.0);
  for (int a = 0; a < 3; ++a)
    sum += std::exp(2 * double{cloud.log_scales[i][a]}) * glm::outerProduct(r[a], r[a]);
  return sum;
}

std::vector<float> color_step_scale(const SplatCloud& cloud) {
  auto extents = extents_of(cloud.log_scales);
  set_opacities(extents, cloud.opacity_logits);
  return step_scale_of(kColorWeight, extents);
}

double difference(const glm::dmat3& a, const glm::dmat3& b) {
  double squares = 0, size = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) {
      squares += (a[c][r] - b[c][r]) * (a[c][r] - b[c][r]);
      size += b[c][r] * b[c][r];
    }
  return std::sqrt(squares / size);
}

double mean_log_scale(const SplatCloud& cloud) {
  double sum = 0;
  for (const glm::vec3& s : cloud.log_scales) sum += double{s.x} + double{s.y} + double{s.z};
  return sum / (3 * static_cast<double>(cloud.size()));
}

glm::dvec3 roots(const glm::vec3& log_scales) { return glm::exp(glm::dvec3(log_scales) / 2.0); }

glm::dvec3 axis(const glm::quat& q) { return {q.x, q.y, q.z}; }

/// The largest distance of each attribute's vector in its own steps, √channels of which it may
/// have.
struct Worst {
  std::map<std::string, double> steps = {};

  void see(const char* name, double distance, double step) {
    steps[name] = std::max(steps[name], distance / step);
  }
};

Worst worst_errors(const SplatCloud& before, const SplatCloud& after,
                   const QuantizationSteps& steps) {
  auto extents = extents_of(after.log_scales);
  const auto opacity = step_scale_of(kOpacityWeight, extents);
  set_opacities(extents, after.opacity_logits);
  const auto rotation = step_scale_of(kRotationWeight, extents);
  const auto color = step_scale_of(kColorWeight, extents);
  const double root_step = 0.5 * double{steps.log_scale} * std::exp(mean_log_scale(before) / 2);
  const auto order = position_order(before.positions, steps.position);
  const auto rest = static_cast<std::size_t>(sh_rest_count(before.sh_degree));
  Worst worst;
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::uint32_t i = order[k];
    worst.see("position",
              glm::distance(glm::dvec3(after.positions[k]), glm::dvec3(before.positions[i])),
              steps.position);
    worst.see("scale", glm::distance(roots(after.log_scales[k]), roots(before.log_scales[i])),
              root_step);
    // The ends that an image cannot tell from 0 and 1 are cut
    const double u = double{opacity_scale(before.opacity_logits[i])};
    worst.see(
        "opacity",
        std::abs(double{opacity_scale(after.opacity_logits[k])} - std::clamp(u, 0.0201, 0.9799)),
        double{steps.opacity * opacity[k]});
    worst.see(
        "rotation",
        glm::distance(axis(after.rotations[k]), axis(canonical_rotation(before.rotations[i]))),
        double{steps.rotation * rotation[k]});
    worst.see("sh_dc", double{glm::distance(after.sh_dc[k], before.sh_dc[i])},
              double{steps.sh_dc * color[k]});
    double squares = 0;
    for (std::size_t s = 0; s < rest; ++s) {
      const glm::dvec3 d =
          glm::dvec3(after.sh_rest[rest * k + s]) - glm::dvec3(before.sh_rest[rest * i + s]);
      squares += glm::dot(d, d);
    }
    if (rest > 0)
      worst.see("sh_rest", std::sqrt(squares / static_cast<double>(rest)),
                double{steps.sh_rest * color[k]});
  }
  return worst;
}

// To the nearest, each of n numbers is off by half a step; by rate, by one and a half.
TEST(Compact, ErrorsFollowTheSteps) {
  for (const double rate_weight : {0.0, kDefaultRateWeight})
    for (int degree = 0; degree <= 3; ++degree) {
      const SplatCloud cloud = test::random_cloud(2000, degree, 5);
      const QuantizationSteps steps{.position = 1e-3,
                                    .log_scale = 0.01f,
                                    .rotation = 0.002f,
                                    .opacity = 0.01f,
                                    .sh_dc = 0.02f,
                                    .sh_rest = 0.03f};
      const auto bytes = encode_compact(cloud, {.steps = steps, .rate_weight = rate_weight});
      ASSERT_TRUE(bytes) << bytes.error().message();
      const auto back = decode_compact(*bytes, cloud.size(), degree);
      ASSERT_TRUE(back) << back.error().message();
      const Worst worst = worst_errors(cloud, *back, steps);
      const double each = rate_weight > 0 ? 1.5 : 0.5;
      std::string line = fmt::format("degree {}, errors in steps (allowed):", degree);
      for (const auto& [name, error] : worst.steps) {
        const double most = name == "position" ? std::sqrt(3.0) / 2
                                               : each * (name == "opacity" ? 1 : std::sqrt(3.0));
        line += fmt::format("  {} {:.2f} ({:.2f})", name, error, most);
        EXPECT_LE(error, 1.01 * most) << name;
        EXPECT_GT(error, 0.4) << name << ": finer than asked, which takes more bits";
      }
      std::puts(line.c_str());
    }
}

TEST(Compact, HalfTurnsAboutTheOwnAxesCostNothing) {
  SplatCloud cloud = test::random_cloud(300, 0, 6);
  const QuantizationSteps fine{.rotation = 1e-4f};
  const auto before = decode_compact(*encode_compact(cloud, {.steps = fine}), cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::quat turns[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, -3}};
    cloud.rotations[i] = cloud.rotations[i] * turns[i % 4];
  }
  const auto after = decode_compact(*encode_compact(cloud, {.steps = fine}), cloud.size(), 0);
  ASSERT_TRUE(before && after);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    ASSERT_LT(difference(shape_of(*before, i), shape_of(*after, i)), 1e-3);
}

TEST(Compact, SplatsThatCountMoreAreMoreExact) {
  SplatCloud cloud = test::random_cloud(4000, 1, 8);
  std::vector<float> weights(cloud.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = i % 2 == 0 ? 5.0f : 0.1f;
  const auto bytes =
      encode_compact(cloud, {.steps = {.sh_rest = 0.4f}, .sensitivity = {.weights = weights}});
  const auto back = decode_compact(*bytes, cloud.size(), 1);
  ASSERT_TRUE(back);
  const auto order = position_order(cloud.positions, QuantizationSteps().position);
  double heavy = 0, light = 0;
  for (std::size_t k = 0; k < cloud.size(); ++k)
    for (std::size_t s = 0; s < 3; ++s) {
      const glm::vec3 d = back->sh_rest[3 * k + s] - cloud.sh_rest[3 * order[k] + s];
      (order[k] % 2 == 0 ? heavy : light) += double{glm::dot(d, d)};
    }
  EXPECT_LT(heavy, 0.8 * light);
}

TEST(Compact, EncodingAgainIsStable) {
  const SplatCloud cloud = test::random_cloud(1000, 1, 7);
  const QuantizationSteps steps;
  const auto once =
      decode_compact(*encode_compact(cloud, {.steps = steps, .rate_weight = 0}), cloud.size(), 1);
  ASSERT_TRUE(once);
  const auto twice =
      decode_compact(*encode_compact(*once, {.steps = steps, .rate_weight = 0}), cloud.size(), 1);
  ASSERT_TRUE(twice);
  const auto order = position_order(once->positions, steps.position);
  for (std::size_t k = 0; k < cloud.size(); ++k)
    ASSERT_LE(glm::distance(twice->positions[k], once->positions[order[k]]), 1e-6f);  // one grid
}

// From a millionth of an atom to beyond all images
TEST(Compact, ScalesOfAnySizeComeBackFinite) {
  SplatCloud cloud = test::random_cloud(50, 1, 10);
  cloud.log_scales[3] = glm::vec3(80, -80, 0);
  cloud.log_scales[4] = glm::vec3(-1e30f, -200, 200);
  cloud.log_scales[5] = glm::vec3(1e30f);
  const auto bytes = encode_compact(cloud, {});
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto back = decode_compact(*bytes, cloud.size(), 1);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(count_non_finite(*back), 0u);
}

TEST(Compact, SmallScenes) {
  EXPECT_TRUE(encode_compact(SplatCloud(), {})->empty());
  EXPECT_EQ(decode_compact({}, 0, 2)->size(), 0u);
  for (const std::size_t count : {1u, 2u, 3u}) {
    const SplatCloud cloud = test::random_cloud(count, 3, 8);
    const auto back = decode_compact(*encode_compact(cloud, {}), count, 3);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->size(), count);
  }
  SplatCloud same = test::random_cloud(1, 1, 9);
  same.resize(50);
  for (std::size_t i = 1; i < 50; ++i) same.rotations[i] = glm::quat(0, 0, 0, 0);  // of no length
  EXPECT_TRUE(decode_compact(*encode_compact(same, {}), 50, 1));
}

TEST(Compact, SectionsAddUp) {
  const SplatCloud cloud = test::random_cloud(500, 1, 3);
  const auto bytes = encode_compact(cloud, {});
  const auto sizes = attribute_bytes(*bytes, 1);
  ASSERT_TRUE(sizes);
  ASSERT_EQ(sizes->size(), 6u);
  std::size_t total = 0;
  for (const auto& [attribute, size] : *sizes) total += size;
  EXPECT_LE(total, bytes->size());
  EXPECT_GE(total + 6 * 3, bytes->size());
}

TEST(Compact, EnergyStandsForColours) {
  const SplatCloud cloud = test::random_cloud(700, 1, 5);
  std::vector<float> energy(kEnergyChannels * cloud.size());
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  for (float& value : energy) value = normal(random);
  const CompactOptions options{.steps = {.energy = 0.02f}, .rate_weight = 0};
  const auto bytes = encode_compact(cloud, options, energy);
  ASSERT_TRUE(bytes);
  std::vector<float> back;
  const auto decoded = decode_compact(*bytes, cloud.size(), 1, &back);
  ASSERT_TRUE(decoded) << decoded.error().message();
  ASSERT_EQ(back.size(), energy.size());
  const auto order = position_order(cloud.positions, QuantizationSteps().position);
  const auto step_scale = color_step_scale(*decoded);
  for (std::size_t i = 0; i < back.size(); ++i) {
    const std::size_t splat = i / kEnergyChannels;
    const float before = energy[order[splat] * kEnergyChannels + i % kEnergyChannels];
    ASSERT_NEAR(back[i], before, 0.01 * std::sqrt(12.0) * double{step_scale[splat]});
  }
  EXPECT_EQ(decoded->sh_dc, std::vector<glm::vec3>(cloud.size(), glm::vec3(0)));
  EXPECT_FALSE(decode_compact(*bytes, cloud.size(), 1));  // another number of channels
  const auto sizes = attribute_bytes(*bytes, 1, true);
  ASSERT_TRUE(sizes);
  EXPECT_EQ(sizes->back().first, "energy");
}

TEST(Compact, BytesThatBelongToNothingAreRefused) {
  const SplatCloud cloud = test::random_cloud(20, 1, 3);
  Bytes bytes = *encode_compact(cloud, {});
  const std::size_t length = std::to_integer<std::size_t>(bytes[0]) & 0x7f;
  const std::size_t high = std::to_integer<std::size_t>(bytes[1]);
  ASSERT_LT(high, 0x80u);  // a varint of two bytes
  const std::size_t section = length + (high << 7);
  bytes.insert(bytes.begin() + 2 + static_cast<std::ptrdiff_t>(section), std::byte{0});
  bytes[0] = static_cast<std::byte>((section + 1) % 128 + 128);
  bytes[1] = static_cast<std::byte>((section + 1) / 128);
  const auto longer = decode_compact(bytes, 20, 1);
  ASSERT_FALSE(longer);
  EXPECT_EQ(longer.error().message(), "position: has bytes left over");
  EXPECT_FALSE(decode_compact(std::vector{std::byte{0}}, 0, 1));
}

TEST(Compact, CutsAndDamage) {
  const SplatCloud cloud = test::random_cloud(60, 1, 4);
  const Bytes good = *encode_compact(cloud, {});
  for (std::size_t size = 0; size < good.size(); ++size)
    ASSERT_FALSE(decode_compact(std::span<const std::byte>(good).first(size), 60, 1)) << size;
  EXPECT_FALSE(decode_compact(good, 61, 1));
  EXPECT_FALSE(decode_compact(good, 60, 2));
  EXPECT_FALSE(decode_compact(good, 60, 0));
  std::mt19937 random(1);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    const auto back = decode_compact(bytes, 60, 1);
    if (back) {
      EXPECT_EQ(count_non_finite(*back), 0u);
    }
  }
}

}  // namespace
}  // namespace fluxgs::codec
