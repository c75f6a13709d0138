// Networks inside of a compact .glb: what is written is what is baked when it is read.
#include "fluxgs/io/compact_glb.h"

#include <cmath>

#include "support.h"
#include "unit/shared-format/glb_support.h"

namespace fluxgs::networks {
namespace {

using fluxgs::test::edited;
using fluxgs::test::json_of;
using fluxgs::test::random_cloud;
using test::onnxruntime_is_loaded;
using test::random_mlp;
using test::random_rows;

constexpr std::size_t kSplats = 300;

CompactNetworks networks_of(const SplatCloud& cloud, bool with_psi, bool with_phi) {
  SplatCloud turned = cloud;
  turn_gltf_frame(turned);
  CompactNetworks n{.models = {}, .normalisation = measure_normalisation(turned)};
  if (with_psi) {
    n.models.psi = *encode_onnx(random_mlp({kPsiColumns, 64, kShColumns}, 1), psi_signature());
    n.energy = random_rows(cloud.size() * kEnergyColumns, 2);
  }
  if (with_phi)
    n.models.phi = *encode_onnx(random_mlp({kPhiColumns, 32, kShColumns}, 3), phi_signature());
  return n;
}

CompactOptions fine_options(const CompactNetworks& networks) {
  return {.steps = {.position = 1e-5,
                    .log_scale = 1e-4f,
                    .rotation = 1e-4f,
                    .opacity = 1e-4f,
                    .sh_dc = 1e-4f,
                    .sh_rest = 1e-4f,
                    .energy = 1e-4f},
          .rate_weight = 0,
          .networks = networks};
}

SplatCloud canonical_cloud(std::size_t count) {
  SplatCloud cloud = random_cloud(count, 1);
  canonicalize_rotations(cloud);
  return cloud;
}

/// The colours that the networks make of the cloud itself, in the order of the file.
SplatCloud baked_directly(const SplatCloud& cloud, const CompactNetworks& networks) {
  SplatCloud result = cloud;
  turn_gltf_frame(result);
  const auto done =
      bake_appearance(result, networks.energy, networks.models, networks.normalisation, "direct");
  EXPECT_TRUE(done) << done.error().message();
  turn_gltf_frame(result);
  return in_order(result, compact_order(cloud, fine_options(networks)));
}

TEST(CompactNetworks, AreBakedWhenTheFileIsRead) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const SplatCloud cloud = canonical_cloud(kSplats);
  for (const auto& [psi, phi] :
       {std::pair(true, true), std::pair(true, false), std::pair(false, true)}) {
    const CompactNetworks networks = networks_of(cloud, psi, phi);
    const auto file = encode_compact_glb(cloud, fine_options(networks), "net.glb");
    ASSERT_TRUE(file) << file.error().message();
    const auto scene = read_glb(*file, "net.glb");
    ASSERT_TRUE(scene) << scene.error().message();
    const SplatCloud expected = baked_directly(cloud, networks);
    ASSERT_EQ(scene->cloud.sh_degree, 1);
    double squares = 0;
    for (std::size_t k = 0; k < kSplats; ++k) {
      ASSERT_LT(glm::distance(scene->cloud.positions[k], expected.positions[k]), 1e-4f);
      const glm::vec3 d = scene->cloud.sh_dc[k] - expected.sh_dc[k];
      squares += double{glm::dot(d, d)};
    }
    EXPECT_LT(std::sqrt(squares / kSplats), 5e-3);
    EXPECT_EQ(scene->attribute_bits.count("energy"), psi ? 1u : 0u);
    EXPECT_EQ(scene->attribute_bits.count("sh_dc"), psi ? 0u : 1u);
    EXPECT_GT(scene->attribute_bits.at("networks"), 1);
  }
}

TEST(CompactNetworks, ServeAllChunks) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const SplatCloud cloud = canonical_cloud(25'000);
  const CompactNetworks networks = networks_of(cloud, true, true);
  const auto file = encode_compact_glb(cloud, fine_options(networks), "net.glb");
  ASSERT_TRUE(file) << file.error().message();
  const auto scene = read_glb(*file, "net.glb");
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->chunks.size(), 4u);
  EXPECT_NEAR(scene->attribute_bits.at("networks") * 25'000 / 8,
              static_cast<double>(networks.models.psi.size() + networks.models.phi.size()), 1);
  const SplatCloud expected = baked_directly(cloud, networks);
  double squares = 0;
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    ASSERT_LT(glm::distance(scene->cloud.positions[k], expected.positions[k]), 1e-4f);
    const glm::vec3 d = scene->cloud.sh_dc[k] - expected.sh_dc[k];
    squares += double{glm::dot(d, d)};
  }
  EXPECT_LT(std::sqrt(squares / 25'000), 5e-3);
  // Others for one of them
  const auto other =
      read_glb(edited(*file, R"("psi":{"bufferView":0})", R"("psi":{"bufferView":1})"), "net.glb");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().message(),
            "net.glb: nodes: show 4 primitives, expected one where networks make the colours");
}

TEST(CompactNetworks, CanonicalRotationsKeepTheCovarianceAndStay) {
  SplatCloud cloud = random_cloud(kSplats, 1);
  const SplatCloud before = cloud;
  canonicalize_rotations(cloud);
  const SplatCloud once = cloud;
  canonicalize_rotations(cloud);
  for (std::size_t i = 0; i < kSplats; ++i) {
    EXPECT_GT(std::abs(glm::dot(once.rotations[i], cloud.rotations[i])), 1 - 1e-5f);
    const glm::mat3 a = glm::mat3_cast(glm::normalize(before.rotations[i]));
    const glm::mat3 b = glm::mat3_cast(once.rotations[i]);
    for (int axis = 0; axis < 3; ++axis)  // the same axes, whichever way they point
      EXPECT_GT(std::abs(glm::dot(a[axis], b[axis])), 1 - 1e-4f);
  }
}

TEST(CompactNetworks, PlainAttributesAreTheBakedOnes) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const SplatCloud cloud = random_cloud(kSplats, 1);
  CompactOptions options = fine_options(networks_of(cloud, true, true));
  options.plain_attributes = true;
  const auto both = encode_compact_glb(cloud, options, "net.glb");
  ASSERT_TRUE(both) << both.error().message();
  const auto own = read_glb(*both, "net.glb");
  const auto plain =
      read_glb(edited(*both, "\"FLUXGS_gaussian_splatting_compact\":{", "\"OTHER_thing\":{"), "o");
  ASSERT_TRUE(own && plain) << plain.error().message();
  EXPECT_EQ(own->cloud.sh_dc, plain->cloud.sh_dc);
  EXPECT_EQ(own->cloud.sh_rest, plain->cloud.sh_rest);
}

TEST(CompactNetworks, WhatDoesNotFitIsRefusedBeforeAnythingIsWritten) {
  const SplatCloud cloud = random_cloud(20, 1);
  CompactNetworks networks = networks_of(cloud, true, false);
  networks.energy.pop_back();
  auto file = encode_compact_glb(cloud, fine_options(networks), "x.glb");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message(), "x.glb: energy: 239 values, expected 240");
  file = encode_compact_glb(random_cloud(20, 2), fine_options(networks_of(cloud, false, true)),
                            "x.glb");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().message(), "x.glb: networks: the scene has degree 2, expected 1");
  EXPECT_FALSE(encode_compact_glb(cloud, fine_options({}), "x.glb"));
}

// Each would be run again, for as long as it may take
TEST(CompactNetworks, BelongToOnePrimitive) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const SplatCloud cloud = random_cloud(20, 1);
  const auto one = encode_compact_glb(cloud, fine_options(networks_of(cloud, true, true)), "x.glb");
  ASSERT_TRUE(one) << one.error().message();
  const auto scene = read_glb(fluxgs::test::joined_glb({*one, *one}), "x.glb");
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().message(),
            "x.glb: nodes: show 2 primitives, expected one where networks make the colours");
}

TEST(CompactNetworks, DamageIsNamed) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const SplatCloud cloud = random_cloud(20, 1);
  const auto good =
      encode_compact_glb(cloud, fine_options(networks_of(cloud, true, true)), "x.glb");
  ASSERT_TRUE(good) << good.error().message();
  const std::tuple<const char*, const char*, const char*> damages[] = {
      {R"("phi":{"bufferView":1})", R"("phi":{"bufferView":9})", "9"},
      {R"("phi":{"bufferView":1})", R"("phi":{"bufferView":0})", "phi"},
      {R"("phi":{"bufferView":1})", R"("phi":{"uri":"model.onnx"})", "phi"},
      {R"("psi":)", R"("chi":)", "channels"},
      {R"("extent":)", R"("extend":)", "normalisation.extent: is missing; expected 1 numbers"},
      {R"("center":[)", R"("center":[1e99,)", "normalisation.center"},
  };
  for (const auto& [from, to, expected] : damages) {
    const auto scene = read_glb(edited(*good, from, to), "x.glb");
    ASSERT_FALSE(scene) << to;
    EXPECT_NE(scene.error().message().find(expected), std::string::npos) << scene.error().message();
  }
}

}  // namespace
}  // namespace fluxgs::networks
