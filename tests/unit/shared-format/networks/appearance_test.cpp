// Baking the networks' colours into a scene.
#include "fluxgs/networks/appearance.h"

#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/shared-format/networks/support.h"

namespace fluxgs::networks {
namespace {

using test::expect_error;

SplatCloud random_cloud(std::size_t count, int degree, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto vec = [&](float scale) {
    return glm::vec3(normal(random), normal(random), normal(random)) * scale;
  };
  SplatCloud cloud;
  cloud.sh_degree = degree;
  cloud.resize(count);
  for (glm::vec3& p : cloud.positions) p = vec(10) + glm::vec3(3, 0, -2);
  for (glm::vec3& s : cloud.log_scales) s = vec(1) - glm::vec3(4);
  for (glm::quat& q : cloud.rotations) {
    q = {normal(random), normal(random), normal(random), normal(random)};
  }
  for (float& o : cloud.opacity_logits) o = 3 * normal(random);
  for (glm::vec3& c : cloud.sh_dc) c = vec(1);
  for (glm::vec3& c : cloud.sh_rest) c = vec(0.2f);
  return cloud;
}

/// y = W·x + b without ReLU, W given by a formula.
template <class Weight>
Mlp linear(int inputs, Weight weight) {
  MlpLayer layer{.inputs = inputs, .outputs = 12, .weights = {}, .bias = {}, .relu = false};
  for (int o = 0; o < 12; ++o) {
    for (int i = 0; i < inputs; ++i) layer.weights.push_back(weight(o, i));
  }
  layer.bias.assign(12, 0);
  return {{layer}};
}

std::vector<std::byte> model(const Mlp& mlp, const Signature& signature) {
  auto bytes = encode_onnx(mlp, signature);
  EXPECT_TRUE(bytes) << bytes.error().message();
  return std::move(*bytes);
}
std::vector<std::byte> random_psi() {
  return model(test::random_mlp({kPsiColumns, 64, 12}, 1), psi_signature());
}
std::vector<std::byte> random_phi() {
  return model(test::random_mlp({kPhiColumns, 128, 64, 32, 12}, 2), phi_signature());
}

TEST(Appearance, RowsByHand) {
  SplatCloud cloud;
  cloud.sh_degree = 1;
  cloud.resize(3);
  cloud.positions = {{2, 4, 6}, {2 + 8, 4, 6 - 6}, {1e30f, 4, 6}};
  cloud.log_scales = {{-1, -3, 1}, {}, {}};
  cloud.rotations = {{-2, 0, 2, 0}, {0, 0, -3, 0}, {0, 0, 0, 0}};  // glm: (w, x, y, z)
  cloud.opacity_logits = {0, std::log(3.0f), -200};
  Normalisation n{.center = {2, 4, 5}, .extent = 2, .log_scale_mean = -1, .log_scale_deviation = 2};
  for (std::size_t k = 0; k < 12; ++k) {
    n.sh_mean[k] = static_cast<float>(k);
    n.sh_deviation[k] = 0.5f;
  }
  const std::vector<float> energy = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 100};
  const std::vector<float> sh(12, 1);

  const auto psi = psi_row(n, cloud, 0, energy);  // μ̂ = (0, 0, 0.5), inside of the unit ball
  for (std::size_t k = 0; k < 11; ++k) EXPECT_EQ(psi[k], energy[k]);
  EXPECT_EQ(psi[11], 64);  // limited
  EXPECT_EQ((std::array{psi[12], psi[13], psi[14]}), (std::array{0.0f, 0.0f, 0.5f}));
  // μ̂ = (4, 0, −2.5), |μ̂|² = 22.25
  const double length = std::sqrt(22.25), factor = (2 - 1 / length) / length;
  const auto outside = psi_row(n, cloud, 1, energy);
  EXPECT_FLOAT_EQ(outside[12], static_cast<float>(4 * factor));
  EXPECT_EQ(outside[13], 0);
  EXPECT_FLOAT_EQ(outside[14], static_cast<float>(-2.5 * factor));
  EXPECT_FLOAT_EQ(psi_row(n, cloud, 2, energy)[12], 2);  // as far as it gets

  const auto phi = phi_row(n, cloud, 0, sh);
  const float root = std::sqrt(0.5f);
  const float first[] = {0, 0, 0.5f, 0, -1, 1, root, 0, -root, 0, 0.5f};
  for (std::size_t k = 0; k < 11; ++k) EXPECT_FLOAT_EQ(phi[k], first[k]) << k;
  for (std::size_t k = 0; k < 12; ++k) EXPECT_FLOAT_EQ(phi[11 + k], 2 - 2 * static_cast<float>(k));
  const auto second = phi_row(n, cloud, 1, sh);
  EXPECT_FLOAT_EQ(second[0], 4);  // not contracted
  const float turned[] = {0, 0, 1, 0};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(second[6 + k], turned[k]);
  EXPECT_FLOAT_EQ(second[10], 0.75f);
  const auto third = phi_row(n, cloud, 2, sh);
  EXPECT_EQ(third[0], 64);
  EXPECT_EQ(third[6], 1);
  EXPECT_EQ(third[10], 0);
}

TEST(Appearance, WithoutNetworksNothingChangesAndNothingIsLoaded) {
  const bool before = test::onnxruntime_is_loaded();
  SplatCloud cloud = random_cloud(10, 3, 1);
  const SplatCloud copy = cloud;
  ASSERT_TRUE(bake_appearance(cloud, {}, {}, {}, "scene.glb"));
  EXPECT_EQ(cloud.sh_degree, 3);
  EXPECT_EQ(cloud.sh_dc, copy.sh_dc);
  EXPECT_EQ(cloud.sh_rest, copy.sh_rest);
  EXPECT_EQ(test::onnxruntime_is_loaded(), before);
}

// Ψ(E, p) = E with the blue of the last coefficient replaced by the depth: coefficients land where
// the header says.
TEST(Appearance, PsiByHand) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const Mlp psi = linear(kPsiColumns, [](int o, int i) {
    return o < 11 ? (o == i ? 1.0f : 0.0f) : (i == 14 ? 1.0f : 0.0f);
  });
  SplatCloud cloud = random_cloud(2, 0, 1);
  cloud.positions = {{0, 0, 0.25f}, {0, 0, 4}};
  std::vector<float> energy(24);
  for (std::size_t k = 0; k < 24; ++k) energy[k] = static_cast<float>(k);
  const auto done = bake_appearance(cloud, energy, {model(psi, psi_signature()), {}}, {}, "s");
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(cloud.sh_degree, 1);
  EXPECT_EQ(cloud.sh_dc[0], glm::vec3(0, 1, 2));
  ASSERT_EQ(cloud.sh_rest.size(), 6u);
  EXPECT_EQ(cloud.sh_rest[0], glm::vec3(3, 4, 5));
  EXPECT_EQ(cloud.sh_rest[1], glm::vec3(6, 7, 8));
  EXPECT_EQ(cloud.sh_rest[2], glm::vec3(9, 10, 0.25f));
  EXPECT_EQ(cloud.sh_dc[1], glm::vec3(12, 13, 14));
  EXPECT_EQ(cloud.sh_rest[5], glm::vec3(21, 22, 1.75f));
}

// Φ adds half of the normalised coefficients and the opacity to the scene's own.
TEST(Appearance, PhiByHandKeepsTheScenesOwnColours) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const Mlp phi = linear(kPhiColumns, [](int o, int i) {
    return i == 11 + o ? 0.5f : i == 10 ? 1.0f : 0.0f;
  });
  const AppearanceNetworks networks{{}, model(phi, phi_signature())};
  SplatCloud cloud = random_cloud(1, 1, 1);
  cloud.opacity_logits = {0};
  cloud.sh_dc = {{1, 2, 3}};
  cloud.sh_rest = {{4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  Normalisation n;
  n.sh_mean[1] = 1;
  n.sh_deviation[11] = 4;
  ASSERT_TRUE(bake_appearance(cloud, {}, networks, n, "s"));
  EXPECT_EQ(cloud.sh_dc[0], glm::vec3(2, 3, 5));          // 2 + 0.5·(2 − 1) + 0.5
  EXPECT_EQ(cloud.sh_rest[2], glm::vec3(15.5f, 17, 14));  // 12 + 0.5·12/4 + 0.5
  SplatCloud flat = random_cloud(1, 0, 1);                // no coefficients of degree 1: zeros
  flat.opacity_logits = {0};
  ASSERT_TRUE(bake_appearance(flat, {}, networks, {}, "s"));
  EXPECT_EQ(flat.sh_degree, 1);
  EXPECT_EQ(flat.sh_rest, std::vector<glm::vec3>(3, glm::vec3(0.5f)));
}

TEST(Appearance, AgreesWithFloat64OverSeveralBatches) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const std::size_t count = 20'000;  // ten batches, the last one not full
  SplatCloud cloud = random_cloud(count, 0, 3);
  const SplatCloud before = cloud;
  std::vector<float> energy = test::random_rows(count * 12, 4);
  const Normalisation n = measure_normalisation(random_cloud(1000, 1, 5));
  const auto done = bake_appearance(cloud, energy, {random_psi(), random_phi()}, n, "s");
  ASSERT_TRUE(done) << done.error().message();
  const Mlp psi = test::random_mlp({kPsiColumns, 64, 12}, 1),
            phi = test::random_mlp({kPhiColumns, 128, 64, 32, 12}, 2);
  double worst = 0;
  for (std::size_t i = 0; i < count; i += 7) {
    const auto in = psi_row(n, before, i, std::span(energy).subspan(12 * i, 12));
    const auto base = evaluate(psi, std::vector<double>(in.begin(), in.end()));
    const std::vector<float> rounded(base.begin(), base.end());
    const auto row = phi_row(n, before, i, rounded);
    const auto offset = evaluate(phi, std::vector<double>(row.begin(), row.end()));
    for (std::size_t k = 0; k < 12; ++k) {
      const glm::vec3& rgb = k < 3 ? cloud.sh_dc[i] : cloud.sh_rest[3 * i + k / 3 - 1];
      worst = std::max(worst, std::fabs(rgb[static_cast<int>(k % 3)] - (base[k] + offset[k])));
    }
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 1e-4);  // coefficients reach 50 here
  EXPECT_EQ(cloud.positions, before.positions);
  EXPECT_EQ(cloud.opacity_logits, before.opacity_logits);

  SplatCloud again = before;
  ASSERT_TRUE(bake_appearance(again, energy, {random_psi(), random_phi()}, n, "s"));
  EXPECT_EQ(again.sh_rest, cloud.sh_rest);  // the same bits every time
}

TEST(Appearance, MeasuresTheScene) {
  SplatCloud cloud;
  cloud.sh_degree = 1;
  cloud.resize(5);
  cloud.positions = {{-2, 0, 0}, {-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1e6f, 0, 0}};
  for (std::size_t i = 0; i < 5; ++i) cloud.log_scales[i] = glm::vec3(i % 2 == 0 ? -1.0f : 4.0f);
  cloud.sh_dc[0].r = 5;
  const Normalisation n = measure_normalisation(cloud);
  EXPECT_EQ(n.center, glm::vec3(0));
  EXPECT_EQ(n.extent, 2);  // the outlier does not count
  EXPECT_FLOAT_EQ(n.log_scale_mean, 1);
  EXPECT_FLOAT_EQ(n.log_scale_deviation, std::sqrt(6.0f));
  EXPECT_FLOAT_EQ(n.sh_mean[0], 1);
  EXPECT_FLOAT_EQ(n.sh_deviation[0], 2);
  EXPECT_EQ(n.sh_mean[5], 0);
  EXPECT_EQ(n.sh_deviation[5], 1e-6f);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}}) {
    SplatCloud few = cloud;
    few.resize(count);
    const Normalisation least = measure_normalisation(few);
    EXPECT_EQ(least.extent, 1e-6f);
  }
}

TEST(Appearance, RefusesWhatDoesNotFit) {
  const AppearanceNetworks psi{random_psi(), {}}, phi{{}, random_phi()};
  const std::vector<float> energy(120);
  SplatCloud cloud = random_cloud(10, 1, 1), rich = random_cloud(10, 2, 1);
  const auto bake = [&](SplatCloud& c, std::span<const float> e, const AppearanceNetworks& nets,
                        const Normalisation& n) { return bake_appearance(c, e, nets, n, "s.glb"); };
  expect_error(bake(rich, {}, phi, {}), {"s.glb: networks", "degree 2; expected 0 or 1"});
  expect_error(bake(cloud, std::span(energy).first(119), psi, {}),
               {"s.glb: energy: 119 values; expected 120"});
  expect_error(bake(cloud, energy, phi, {}), {"120 values; expected 0"});
  Normalisation flat;
  flat.extent = 0;
  expect_error(bake(cloud, energy, psi, flat), {"s.glb: normalisation", "at least 1e-6"});
  Normalisation nan;
  nan.sh_mean[3] = std::nanf("");
  expect_error(bake(cloud, energy, psi, nan), {"normalisation", "not finite"});
  Normalisation endless;
  endless.sh_deviation[3] = std::numeric_limits<float>::infinity();
  expect_error(bake(cloud, energy, psi, endless), {"normalisation", "at least 1e-6"});
  expect_error(bake(cloud, energy, {random_phi(), {}}, {}),
               {"s.glb: network psi: input \"scale\" is not expected"});
  expect_error(bake(cloud, {}, {{}, random_psi()}, {}), {"network phi: input \"energy\""});
  expect_error(bake(cloud, {}, {{}, test::Bytes(100)}, {}), {"s.glb: network phi"});
}

TEST(Appearance, RefusesColoursThatAreNotFinite) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  SplatCloud cloud = random_cloud(10, 1, 1);
  cloud.sh_dc[4].g = 3e38f;
  const Mlp one = linear(kPhiColumns, [](int o, int i) { return o == i - 11 ? 5e36f : 0.0f; });
  Normalisation n;
  n.sh_deviation.fill(1e-3f);
  expect_error(bake_appearance(cloud, {}, {{}, model(one, phi_signature())}, n, "s.glb"),
               {"s.glb: networks: the colour of splat 4 is not finite"});
}

TEST(Appearance, AnEmptySceneIsAScene) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  SplatCloud cloud;
  ASSERT_TRUE(bake_appearance(cloud, {}, {random_psi(), random_phi()}, {}, "s.glb"));
  EXPECT_EQ(cloud.size(), 0u);
  EXPECT_EQ(cloud.sh_degree, 1);
}

}  // namespace
}  // namespace fluxgs::networks
