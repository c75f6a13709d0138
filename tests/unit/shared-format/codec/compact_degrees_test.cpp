// Compact files of scenes whose splats differ in degree: a primitive for each degree.
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include <nlohmann/json.hpp>

#include "codec/compact.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/splat_degree.h"
#include "support/sanitized.h"
#include "unit/shared-format/glb_support.h"

namespace fluxgs {
namespace {

using namespace test;
using nlohmann::json;

constexpr char kExtension[] = "FLUXGS_gaussian_splatting_compact";
constexpr QuantizationSteps kFine{.position = 1e-5,
                                  .log_scale = 1e-4f,
                                  .rotation = 1e-4f,
                                  .opacity = 1e-4f,
                                  .sh_dc = 1e-4f,
                                  .sh_rest = 1e-4f};

/// Leaves splat i without the bands above a degree.
void limit_splat(SplatCloud& cloud, std::size_t i, int degree) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (auto k = static_cast<std::size_t>(sh_rest_count(degree)); k < rest; ++k)
    cloud.sh_rest[i * rest + k] = glm::vec3(0);
}

/// Splats in random places, of the degrees 2, 0, 3, 1, 2, …
SplatCloud mixed_cloud(std::size_t count) {
  constexpr int kDegrees[] = {2, 0, 3, 1};
  SplatCloud cloud = random_cloud(count, 3);
  for (std::size_t i = 0; i < count; ++i) limit_splat(cloud, i, kDegrees[i % 4]);
  return cloud;
}

/// So many splats of each degree, in a cloud of degree 3.
SplatCloud cloud_of_degrees(const DegreeCounts& counts) {
  SplatCloud cloud = random_cloud(counts[0] + counts[1] + counts[2] + counts[3], 3);
  std::size_t i = 0;
  for (int degree = 0; degree < 4; ++degree)
    for (std::size_t k = 0; k < counts[static_cast<std::size_t>(degree)]; ++k)
      limit_splat(cloud, i++, degree);
  return cloud;
}

Bytes compact_glb(const SplatCloud& cloud, bool plain_attributes = false) {
  return *encode_compact_glb(cloud, {kFine, plain_attributes, 0}, "small.glb");
}

json primitives_of(const Bytes& glb) {
  return json::parse(json_of(glb)).at("meshes").at(0).at("primitives");
}

TEST(SplatDegree, IsTheHighestBandThatIsNotZero) {
  SplatCloud cloud;
  cloud.sh_degree = 3;
  cloud.resize(6);
  cloud.sh_rest[0 * 15 + 14].z = 1e-30f;
  cloud.sh_rest[1 * 15 + 7].x = -1;
  cloud.sh_rest[2 * 15 + 0].y = std::numeric_limits<float>::quiet_NaN();
  cloud.sh_rest[3 * 15 + 8].y = -0.0f;
  cloud.sh_rest[4 * 15 + 3].x = 1;
  const int expected[] = {3, 2, 1, 0, 2, 0};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(sh_degree_of(cloud, i), expected[i]) << i;
  EXPECT_EQ(count_degrees(cloud), (DegreeCounts{2, 1, 2, 1}));
  EXPECT_EQ(count_degrees({}), DegreeCounts{});
  EXPECT_EQ(count_degrees(random_cloud(7, 0)), (DegreeCounts{7, 0, 0, 0}));
}

TEST(CompactDegrees, ComeBackBucketByBucketWithTheirOwnBandsOnly) {
  const SplatCloud cloud = mixed_cloud(2400);
  const Bytes glb = compact_glb(cloud);
  EXPECT_EQ(primitives_of(glb).size(), 4u);
  const auto scene = read(glb);
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->cloud.size(), cloud.size());
  ASSERT_EQ(scene->cloud.sh_degree, 3);
  EXPECT_EQ(count_degrees(scene->cloud), count_degrees(cloud));
  SplatCloud expected = in_order(cloud, compact_order(cloud, {kFine}));
  canonicalize_rotations(expected);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const SplatCloud& found = scene->cloud;
    ASSERT_EQ(sh_degree_of(found, i), static_cast<int>(i / 600)) << i;
    ASSERT_LT(glm::distance(expected.positions[i], found.positions[i]), 2e-5f);
    ASSERT_LT(glm::distance(expected.log_scales[i], found.log_scales[i]), 2e-2f);
    ASSERT_GT(std::abs(glm::dot(expected.rotations[i], found.rotations[i])), 1 - 1e-5f);
    ASSERT_NEAR(codec::opacity_scale(expected.opacity_logits[i]),
                codec::opacity_scale(found.opacity_logits[i]), 1e-2);
    ASSERT_LT(glm::distance(expected.sh_dc[i], found.sh_dc[i]), 1e-2f);
    for (std::size_t k = 15 * i; k < 15 * (i + 1); ++k)
      ASSERT_LT(glm::distance(expected.sh_rest[k], found.sh_rest[k]), 2e-2f);
  }
}

// As in one stream: the encoder makes up for what each stream's steps are relative to.
TEST(CompactDegrees, AreRoundedAlike) {
  SplatCloud cloud = cloud_of_degrees({1500, 0, 0, 1500});
  for (std::size_t i = 0; i < 1500; ++i) {  // smaller and of lower opacity than the others
    cloud.log_scales[i] -= 1.0f;
    cloud.opacity_logits[i] -= 1.0f;
  }
  SplatCloud alike = cloud;  // has degree 3 throughout, and so one stream
  for (std::size_t i = 0; i < 1500; ++i) alike.sh_rest[15 * i + 14].x = 1e-6f;
  const CompactOptions options{.steps = default_quantization_steps(cloud, 0.2), .rate_weight = 0};
  // Root mean square errors of opacity, colour and size of the first and the last 1500
  const auto errors = [&](const SplatCloud& stored) {
    const auto scene = read_glb(*encode_compact_glb(stored, options, "x"), "x");
    const auto order = compact_order(stored, options);
    std::array<double, 6> sums{};
    for (std::size_t k = 0; k < order.size(); ++k) {
      const std::uint32_t i = order[k];
      const std::size_t at = i < 1500 ? 0 : 3;
      const glm::vec3 color = scene->cloud.sh_dc[k] - cloud.sh_dc[i];
      const glm::vec3 root =
          glm::exp(0.5f * scene->cloud.log_scales[k]) - glm::exp(0.5f * cloud.log_scales[i]);
      const double opacity = double{codec::opacity_scale(scene->cloud.opacity_logits[k])} -
                             double{codec::opacity_scale(cloud.opacity_logits[i])};
      sums[at] += opacity * opacity;
      sums[at + 1] += double{glm::dot(color, color)};
      sums[at + 2] += double{glm::dot(root, root)};
    }
    for (double& sum : sums) sum = std::sqrt(sum / 1500);
    return sums;
  };
  EXPECT_EQ(primitives_of(*encode_compact_glb(cloud, options, "x")).size(), 2u);
  EXPECT_EQ(primitives_of(*encode_compact_glb(alike, options, "x")).size(), 1u);
  const auto apart = errors(cloud), together = errors(alike);
  for (std::size_t e = 0; e < 6; ++e) EXPECT_NEAR(apart[e] / together[e], 1, 0.06) << e;
}

// Streams take weights as 1 on the average; a bit must cost as much in all of them.
TEST(CompactDegrees, WeightsCountAsWithinTheWhole) {
  SplatCloud cloud;
  cloud.resize(4);
  SensitivityWeights sensitivity{.weights = {1, 1, 3, 3}};
  const std::vector<std::uint32_t> light{0, 1}, heavy{2, 3}, all{0, 1, 2, 3};
  const auto low = codec::RateWeights(cloud, sensitivity).of(light);
  const auto high = codec::RateWeights(cloud, sensitivity).of(heavy);
  for (const auto member : {&codec::RateFactors::scale, &codec::RateFactors::opacity,
                            &codec::RateFactors::rotation, &codec::RateFactors::color}) {
    EXPECT_DOUBLE_EQ(low.*member, 2);
    EXPECT_DOUBLE_EQ(high.*member, 2.0 / 3);
    EXPECT_EQ(codec::RateWeights(cloud, sensitivity).of(all).*member, 1);
    EXPECT_EQ(codec::RateWeights(cloud, {}).of(light).*member, 1);
    EXPECT_EQ(codec::RateWeights(cloud, {.weights = std::vector<float>(4)}).of(light).*member, 1);
  }
  // By the means of their diagonals where there are costs
  sensitivity.scale = {1, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 2, 1, 0, 3, 0, 0, 1, 1, 0, 4, 0, 0, 0};
  EXPECT_NEAR(codec::RateWeights(cloud, sensitivity).of(light).scale, 4.0 / 3, 1e-6);
  EXPECT_EQ(codec::RateWeights(cloud, sensitivity).of(light).rotation, 2);
  sensitivity.scale = {};
  // Twice the size, and so 2^0.7 times finer steps of colours: in such steps errors weigh less
  for (const std::uint32_t i : heavy) cloud.log_scales[i] = glm::vec3(std::log(2.0f));
  const auto large = codec::RateWeights(cloud, sensitivity).of(heavy);
  const double in_steps = 3 / std::exp2(1.4);
  EXPECT_DOUBLE_EQ(large.scale, 2.0 / 3);
  EXPECT_NEAR(large.color, (1 + in_steps) / 2 / in_steps, 1e-5);
}

TEST(CompactDegrees, OneDegreeIsOnePrimitiveAndTheStreamOfTheWholeCloud) {
  for (int degree = 0; degree <= 3; ++degree) {
    SplatCloud cloud = random_cloud(700, degree);
    const Bytes glb = compact_glb(cloud);
    EXPECT_EQ(primitives_of(glb).size(), 1u);
    turn_gltf_frame(cloud);
    Bytes stream = *codec::encode_compact(cloud, {.steps = kFine, .rate_weight = 0});
    stream.resize((stream.size() + 3) / 4 * 4);
    EXPECT_EQ(bin_of(glb), stream);
  }
}

TEST(CompactDegrees, SmallBucketsJoinTheNext) {
  const auto degrees = [](const DegreeCounts& counts) {
    const SplatCloud cloud = cloud_of_degrees(counts);
    const Bytes glb = compact_glb(cloud);
    std::vector<std::size_t> list;  // names and splats of each primitive
    const json document = json::parse(json_of(glb));
    for (const json& primitive : document.at("meshes").at(0).at("primitives")) {
      const json& attributes = primitive.at("attributes");
      const std::size_t index = attributes.at("POSITION");
      list.push_back(attributes.size() - 5);
      list.push_back(document.at("accessors").at(index).at("count"));
    }
    const auto scene = read(glb);
    EXPECT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->cloud.size(), cloud.size());
    EXPECT_EQ(compact_order(cloud).size(), cloud.size());
    return list;
  };
  using List = std::vector<std::size_t>;
  EXPECT_EQ(degrees({600, 0, 0, 5}), (List{0, 600, 15, 5}));
  EXPECT_EQ(degrees({511, 0, 0, 5}), (List{15, 516}));
  EXPECT_EQ(degrees({300, 300, 0, 600}), (List{3, 600, 15, 600}));
  EXPECT_EQ(degrees({600, 300, 300, 0}), (List{0, 600, 8, 600}));  // no band that no splat has
  EXPECT_EQ(degrees({0, 0, 9, 0}), (List{8, 9}));
}

TEST(CompactDegrees, PlainAttributesSayTheSame) {
  const SplatCloud cloud = cloud_of_degrees({600, 600, 0, 600});
  const auto compact = read(compact_glb(cloud, false));
  const Bytes both = compact_glb(cloud, true);
  std::string text = json_of(both);
  for (std::size_t at = 0; (at = text.find(kExtension, at)) != std::string::npos;)
    text.replace(at, 6, "OTHERS");
  const auto plain = read(make_glb(text, bin_of(both)));  // by one that does not know ours
  ASSERT_TRUE(compact && plain) << plain.error().message();
  EXPECT_EQ(compact->cloud.positions, plain->cloud.positions);
  EXPECT_EQ(compact->cloud.sh_dc, plain->cloud.sh_dc);
  EXPECT_EQ(compact->cloud.sh_rest, plain->cloud.sh_rest);
}

TEST(CompactDegrees, BitsAreAddedAndWeightsFollowTheirSplats) {
  const SplatCloud cloud = mixed_cloud(8000);
  std::vector<float> weights(cloud.size(), 1);
  weights[4001] = 1e4f;
  const CompactOptions options{.steps = default_quantization_steps(cloud),
                               .sensitivity = {.weights = weights}};
  const Bytes glb = *encode_compact_glb(cloud, options, "x");
  const auto scene = read(glb);
  ASSERT_TRUE(scene);
  double sum = 0;
  for (const auto& [attribute, bits] : scene->attribute_bits) sum += bits;
  EXPECT_EQ(scene->attribute_bits.size(), 6u);
  const double json_bits = 8.0 * static_cast<double>(json_of(glb).size()) / 8000;
  EXPECT_NEAR(sum + json_bits, 8.0 * static_cast<double>(glb.size()) / 8000, 0.2);
  SplatCloud torn = cloud;
  torn.sh_rest[15 * 5 + 2].x = std::numeric_limits<float>::quiet_NaN();
  torn.positions[6].y = std::numeric_limits<float>::infinity();
  EXPECT_EQ(read(*encode_compact_glb(torn, options, "x"))->cloud.size(), 7998u);
  SplatCloud far = cloud;
  far.sh_rest[15 * 2 + 14].x = 1e30f;
  const auto refused = encode_compact_glb(far, options, "far.glb");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "sh_rest") << refused.error().message();
}

TEST(CompactDegrees, LyingBucketsAreNamed) {
  const Bytes good = compact_glb(cloud_of_degrees({600, 600, 0, 600}));
  const auto damaged = [&](const std::function<void(json&)>& damage) {
    json document = json::parse(json_of(good));
    damage(document);
    return read(make_glb(document.dump(), bin_of(good)));
  };
  const auto primitive = [](json& d, std::size_t i) -> json& {
    return d["meshes"][0]["primitives"][i];
  };
  const auto view = [&](json& d, std::size_t i) -> json& {
    return primitive(
        d, i)["extensions"]["KHR_gaussian_splatting"]["extensions"][kExtension]["bufferView"];
  };
  expect_error(damaged([&](json& d) {
                 for (const auto& [name, index] : primitive(d, 1)["attributes"].items())
                   d["accessors"][index.get<std::size_t>()]["count"] = 601;
               }),
               {"primitives[1]", "601"});
  expect_error(damaged([&](json& d) {
                 for (const auto& [name, index] : primitive(d, 2)["attributes"].items())
                   d["accessors"][index.get<std::size_t>()]["count"] = 4000000000;
               }),
               {"primitives[2]", "4000000000 splats in"});
  expect_error(damaged([&](json& d) { std::swap(view(d, 0), view(d, 2)); }), {"primitives[0]"});
  expect_error(damaged([&](json& d) { view(d, 1) = 9; }), {"bufferView"});
  expect_error(damaged([&](json& d) { primitive(d, 1)["mode"] = 4; }), {"primitives[1]", "POINTS"});
  expect_error(
      damaged([&](json& d) { primitive(d, 1)["attributes"] = primitive(d, 0)["attributes"]; }),
      {"primitives[1]"});
  expect_error(damaged([&](json& d) {
                 primitive(d, 2)["attributes"].erase("KHR_gaussian_splatting:SH_DEGREE_2_COEF_1");
               }),
               {"primitives[2]", "SH_DEGREE_2_COEF_1 is missing"});
  // One that is gone, and another order, are scenes
  const auto fewer = damaged([&](json& d) { d["meshes"][0]["primitives"].erase(2); });
  ASSERT_TRUE(fewer) << fewer.error().message();
  EXPECT_EQ(fewer->cloud.sh_degree, 1);
  EXPECT_EQ(fewer->cloud.size(), 1200u);
  const auto turned = damaged([&](json& d) { std::swap(primitive(d, 0), primitive(d, 2)); });
  ASSERT_TRUE(turned) << turned.error().message();
  EXPECT_EQ(sh_degree_of(turned->cloud, 0), 3);
}

TEST(CompactDegrees, PrimitivesOfOtherKindsAreReadBesideThem) {
  const SplatCloud cloud = random_cloud(20, 2);
  const auto scene = read(joined_glb({compact_glb(cloud_of_degrees({600, 0, 0, 600})),
                                      *encode_glb(cloud, "x"), compact_glb(cloud, true)}));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->cloud.sh_degree, 3);
  EXPECT_EQ(count_degrees(scene->cloud), (DegreeCounts{600, 0, 40, 600}));
  EXPECT_EQ(scene->cloud.positions[1205], cloud.positions[5]);
}

TEST(CompactDegrees, AThousandPrimitivesAreAScene) {
  constexpr std::size_t kCount = test::kSanitized ? 100 : 1000;
  std::vector<Bytes> files;
  for (std::uint32_t i = 0; i < kCount; ++i)
    files.push_back(compact_glb(random_cloud(2, static_cast<int>(i % 4), i)));
  const auto scene = read(joined_glb(files));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(count_degrees(scene->cloud),
            (DegreeCounts{kCount / 2, kCount / 2, kCount / 2, kCount / 2}));
}

// A stream of few bytes may hold 4096 splats more than those: a thousand primitives may not.
TEST(CompactDegrees, AThousandPrimitivesAreNoWayToAskForMemory) {
  SplatCloud cloud;
  cloud.resize(4000);
  json document = json::parse(json_of(compact_glb(cloud)));
  json& primitives = document["meshes"][0]["primitives"];
  for (int i = 1; i < 1000; ++i) primitives.push_back(json(primitives[0]));
  expect_error(read(make_glb(document.dump(), bin_of(compact_glb(cloud)))),
               {"show more splats by repeating meshes than a file of"});
}

}  // namespace
}  // namespace fluxgs
