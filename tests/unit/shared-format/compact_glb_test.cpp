// FLUXGS_gaussian_splatting_compact: a .glb with the compact codec's bytes inside.
#include "fluxgs/io/compact_glb.h"

#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/math/logistic.h"
#include "glb_support.h"
#include "support/sanitized.h"

namespace fluxgs {
namespace {

using namespace test;
using nlohmann::json;

constexpr char kExtension[] = "FLUXGS_gaussian_splatting_compact";

CompactOptions exact(bool plain_attributes = false) {
  return {{.position = 1e-5,
           .log_scale = 1e-4f,
           .rotation = 1e-4f,
           .opacity = 1e-4f,
           .sh_dc = 1e-4f,
           .sh_rest = 1e-4f},
          plain_attributes,
          0};
}

Bytes compact_glb(const SplatCloud& cloud, bool plain_attributes = false) {
  return *encode_compact_glb(cloud, exact(plain_attributes), "small.glb");
}

TEST(CompactGlb, ComesBackInMortonOrder) {
  for (int degree = 0; degree <= 3; ++degree) {
    const SplatCloud cloud = random_cloud(500, degree);
    const auto scene = read(compact_glb(cloud));
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_EQ(scene->cloud.size(), cloud.size());
    ASSERT_EQ(scene->cloud.sh_degree, degree);
    // The order is that of glTF's frame; nearest neighbours tell which is which
    const auto rest = static_cast<std::size_t>(sh_rest_count(degree));
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      std::size_t i = 0;
      for (std::size_t j = 1; j < cloud.size(); ++j)
        if (glm::distance(cloud.positions[j], scene->cloud.positions[k]) <
            glm::distance(cloud.positions[i], scene->cloud.positions[k]))
          i = j;
      ASSERT_LT(glm::distance(cloud.positions[i], scene->cloud.positions[k]), 1e-4f);
      ASSERT_LT(glm::distance(cloud.sh_dc[i], scene->cloud.sh_dc[k]), 1e-2f);
      for (std::size_t s = 0; s < rest; ++s)
        ASSERT_LT(glm::distance(cloud.sh_rest[rest * i + s], scene->cloud.sh_rest[rest * k + s]),
                  2e-2f);
      const glm::vec3 x(0.3f, -0.5f, 0.8f);  // the two ellipsoids' widths along a direction
      const auto width = [&](const SplatCloud& c, std::size_t at) {
        const glm::vec3 own = glm::inverse(glm::normalize(c.rotations[at])) * x;
        return glm::length(own * glm::exp(c.log_scales[at]));
      };
      ASSERT_NEAR(width(scene->cloud, k) / width(cloud, i), 1, 0.02);
    }
  }
}

TEST(CompactGlb, PlainAttributesSayTheSame) {
  const SplatCloud cloud = random_cloud(300, 2);
  const auto compact = read(compact_glb(cloud, false));
  const Bytes both = compact_glb(cloud, true);
  const auto with_plain = read(both);
  // A reader that does not know the extension
  const auto plain = read(edited(both, kExtension, "OTHERS_gaussian_splatting_unknown"));
  ASSERT_TRUE(compact && with_plain && plain);
  EXPECT_EQ(compact->cloud.positions, with_plain->cloud.positions);
  EXPECT_EQ(compact->cloud.positions, plain->cloud.positions);
  EXPECT_EQ(compact->cloud.sh_rest, plain->cloud.sh_rest);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(compact->cloud.log_scales[i][c], plain->cloud.log_scales[i][c], 1e-5);
}

TEST(CompactGlb, RequiresTheExtensionOnlyWithoutPlainAttributes) {
  const json alone = json::parse(json_of(compact_glb(random_cloud(9, 1), false)));
  const json both = json::parse(json_of(compact_glb(random_cloud(9, 1), true)));
  EXPECT_EQ(alone.at("extensionsRequired"), json({"KHR_gaussian_splatting", kExtension}));
  EXPECT_FALSE(both.contains("extensionsRequired"));
  EXPECT_EQ(both.at("extensionsUsed"), alone.at("extensionsUsed"));
}

TEST(CompactGlb, TellsTheBitsOfEachAttribute) {
  const Bytes glb = *encode_compact_glb(random_cloud(20000, 1), {}, "x.glb");
  const auto scene = read_scene(glb, "x.glb");
  ASSERT_TRUE(scene);
  double sum = 0;
  for (const auto& [attribute, bits] : scene->attribute_bits) sum += bits;
  EXPECT_EQ(scene->attribute_bits.size(), 6u);
  EXPECT_NEAR(sum, 8.0 * static_cast<double>(glb.size()) / 20000, 1.5);
  EXPECT_EQ(scene->format, "glb");
}

TEST(CompactGlb, EmptyAndTinyAndUniformScenes) {
  const auto empty = read(compact_glb({}));
  ASSERT_TRUE(empty) << empty.error().message();
  EXPECT_EQ(empty->cloud.size(), 0u);
  for (const std::size_t count : {1u, 2u, 3u, 50000u}) {
    SplatCloud cloud;
    cloud.resize(count);  // all alike: next to no bits, were it not for the bound on counts
    const Bytes glb = compact_glb(cloud);
    const auto scene = read(glb);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->cloud.size(), count);
  }
}

TEST(CompactGlb, NonFiniteSplatsAreLeftOut) {
  SplatCloud cloud = random_cloud(20, 1);
  cloud.positions[3].y = std::numeric_limits<float>::infinity();
  cloud.sh_rest[5].x = std::numeric_limits<float>::quiet_NaN();
  const auto scene = read(compact_glb(cloud));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->cloud.size(), 18u);
}

TEST(CompactGlb, ValuesBeyondTheStepsReachAreAnError) {
  SplatCloud cloud = random_cloud(20, 0);
  cloud.positions[3].y = 1e30f;
  const auto glb = encode_compact_glb(cloud, exact(), "far.glb");
  ASSERT_FALSE(glb);
  EXPECT_EQ(glb.error().file, "far.glb");
  EXPECT_EQ(glb.error().field, "positions");
  const auto usual = encode_compact_glb(cloud, {default_quantization_steps(cloud)}, "far.glb");
  EXPECT_TRUE(usual) << usual.error().message();
}

TEST(CompactGlb, SplatsOfAbsurdSizesAreWrittenWithUsualSteps) {
  for (const float log_scale : {1e30f, -1e30f, 80.0f, -80.0f}) {
    SplatCloud cloud = random_cloud(20, 1);
    for (glm::vec3& s : cloud.log_scales) s = glm::vec3(log_scale, -log_scale, log_scale);
    const auto glb = encode_compact_glb(cloud, {default_quantization_steps(cloud)}, "x.glb");
    ASSERT_TRUE(glb) << log_scale << ": " << glb.error().message();
    EXPECT_EQ(read(*glb)->cloud.size(), 20u);
  }
}

// Splat i of the file was made of sines of i, before its values were rounded.
TEST(CompactGlb, FilesOfVersion2AreRead) {
  const auto scene =
      read_scene(std::filesystem::path(FLUXGS_GOLDEN_FOLDER) / "compact_version2.glb");
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->cloud.size(), 64u);
  ASSERT_EQ(scene->cloud.sh_degree, 1);
  const auto wave = [](int i, int k) { return static_cast<float>(std::sin(1.3 * i * k + k)); };
  for (int i = 0; i < 64; ++i) {
    const glm::vec3 position(wave(i, 1), wave(i, 2), wave(i, 3));
    std::size_t found = 0;
    for (std::size_t k = 1; k < 64; ++k)
      if (glm::distance(scene->cloud.positions[k], position) <
          glm::distance(scene->cloud.positions[found], position))
        found = k;
    EXPECT_LT(glm::distance(scene->cloud.positions[found], position), 0.015f) << i;
    EXPECT_NEAR(sigmoid(scene->cloud.opacity_logits[found]), sigmoid(2 * wave(i, 17)), 0.04) << i;
  }
}

TEST(CompactGlb, WeightsMustBeOneForEachSplat) {
  SplatCloud cloud = random_cloud(20, 0);
  const auto wrong = encode_compact_glb(cloud, {.sensitivity = {.weights = {1, 2}}}, "x.glb");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message(),
            "x.glb: weights: 2 of them, expected one for each of 20 splats");
  cloud.positions[3].y = std::numeric_limits<float>::infinity();  // left out with its weight
  EXPECT_TRUE(
      encode_compact_glb(cloud, {.sensitivity = {.weights = std::vector<float>(20, 1)}}, "x.glb"));
}

struct Damage {
  const char *from, *to, *expected;
};

TEST(CompactGlb, DamageIsNamed) {
  const Bytes good = compact_glb(random_cloud(64, 1));
  const Damage damages[] = {
      {R"("version":3)", R"("version":1)", "version: is 1; this program reads versions 2 and 3"},
      {R"("version":3)", R"("vers":3)", "version: is"},
      {R"("version":3)", R"("version":2)", "position"},
      {R"("bufferView":0)", R"("bufferView":1)", "bufferView"},
      {R"("bufferView":0)", R"("bufferView":-1)", "expected a whole number"},
      {R"("count":64)", R"("count":65)", "has 65 elements"},
      {R"("KHR_gaussian_splatting:SH_DEGREE_1_COEF_0")", R"("X")", "SH_DEGREE_1_COEF_0 is missing"},
      {R"("KHR_gaussian_splatting:OPACITY")", R"("X")",
       "KHR_gaussian_splatting:OPACITY is missing"},
      {R"("type":"VEC4")", R"("type":"VEC3")", "is VEC3 of float; expected VEC4 of float"},
      {R"("componentType":5126)", R"("componentType":5121)", "of unsigned byte; expected"},
  };
  for (const auto& [from, to, expected] : damages) {
    std::string text = json_of(good);
    const std::size_t at = text.rfind(from);
    ASSERT_NE(at, std::string::npos) << from;
    const auto scene = read(make_glb(text.replace(at, std::strlen(from), to), bin_of(good)));
    ASSERT_FALSE(scene) << from;
    EXPECT_NE(scene.error().message().find(expected), std::string::npos) << scene.error().message();
  }
}

TEST(CompactGlb, MoreSplatsThanBytesAreRefusedBeforeMemoryIsTaken) {
  const Bytes good = compact_glb(random_cloud(64, 0));
  std::string text = json_of(good);
  for (std::size_t at = 0; (at = text.find(R"("count":64)", at)) != std::string::npos;)
    text.replace(at, 10, R"("count":4000000000)");
  const auto scene = read(make_glb(text, bin_of(good)));
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message().find("4000000000 splats in"), std::string::npos)
      << scene.error().message();
}

TEST(CompactGlb, CutsAndFlippedBitsAreAnErrorOrASceneOfThatSize) {
  const Bytes good = compact_glb(random_cloud(40, 1));
  const Bytes bin = bin_of(good);
  const std::string text = json_of(good);
  for (std::size_t i = 0; i < bin.size(); i += test::kSanitized ? 3 : 1) {
    Bytes bad = bin;
    bad[i] ^= std::byte{0x24};
    const auto scene = read(make_glb(text, bad));
    if (scene) {
      ASSERT_EQ(scene->cloud.size() + scene->dropped, 40u);
    } else {
      ASSERT_EQ(scene.error().file, "test.glb");
    }
    // The chunk itself is padded to a multiple of 4
    if (i + 4 > bin.size()) continue;
    ASSERT_FALSE(read(make_glb(text, Bytes(bin.begin(), bin.begin() + static_cast<long>(i)))));
  }
}

TEST(CompactGlb, NodesAndSeveralPrimitivesAreApplied) {
  const SplatCloud cloud = random_cloud(30, 1);
  const Bytes good = compact_glb(cloud);
  const auto straight = read(good);
  const auto moved = read(edited(good, R"("nodes":[{"mesh":0}])",
                                 R"("nodes":[{"mesh":0,"translation":[1,2,3],"scale":[2,2,2]}])"));
  ASSERT_TRUE(straight && moved) << moved.error().message();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::vec3 expected = 2.0f * straight->cloud.positions[i] + glm::vec3(-1, -2, 3);
    ASSERT_LT(glm::distance(expected, moved->cloud.positions[i]), 1e-4f);
    ASSERT_NEAR(moved->cloud.log_scales[i].x, straight->cloud.log_scales[i].x + std::log(2.0f),
                1e-5);
    ASSERT_LT(glm::distance(moved->cloud.sh_rest[i], straight->cloud.sh_rest[i]), 1e-4f);
  }
  const auto twice =
      read(edited(edited(good, R"("nodes":[{"mesh":0}])", R"("nodes":[{"mesh":0},{"mesh":0}])"),
                  R"("nodes":[0])", R"("nodes":[0,1])"));
  ASSERT_TRUE(twice) << twice.error().message();
  EXPECT_EQ(twice->cloud.size(), 60u);
}

}  // namespace
}  // namespace fluxgs
