// KHR_gaussian_splatting_compression_spz_2: a .glb with SPZ inside.
#include "fluxgs/io/file.h"
#include "glb_support.h"
#include "spz_support.h"

namespace fluxgs {
namespace {

using namespace test;

glm::vec3 to_gltf(const glm::vec3& p) { return {-p.x, -p.y, p.z}; }

// The bounds of the scene's positions in glTF's frame, as JSON; `turned` as if the values stored in
// the SPZ were glTF's.
std::string bounds_of(const SplatCloud& cloud, bool turned) {
  glm::vec3 least(1e9f), most(-1e9f);
  for (const glm::vec3& p : cloud.positions) {
    const glm::vec3 g = turned ? glm::vec3(p.x, -p.y, -p.z) : to_gltf(p);
    least = glm::min(least, g);
    most = glm::max(most, g);
  }
  return fmt::format(R"("min":[{},{},{}],"max":[{},{},{}],)", least.x, least.y, least.z, most.x,
                     most.y, most.z);
}

Bytes spz_glb(const Bytes& spz, std::size_t count, int degree, const std::string& bounds) {
  std::string attributes = R"("POSITION":0,"COLOR_0":1,"KHR_gaussian_splatting:SCALE":2,)"
                           R"("KHR_gaussian_splatting:ROTATION":3)";
  for (int l = 1; l <= degree; ++l) {
    for (int i = 0; i <= 2 * l; ++i) {
      attributes += fmt::format(R"(,"KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}":2)", l, i);
    }
  }
  const std::string extension = "KHR_gaussian_splatting_compression_spz_2";
  const std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_gaussian_splatting","{0}"],)"
      R"("extensionsRequired":["KHR_gaussian_splatting","{0}"],)"
      R"("accessors":[{{{1}"componentType":5126,"count":{2},"type":"VEC3"}},)"
      R"({{"componentType":5121,"normalized":true,"count":{2},"type":"VEC4"}},)"
      R"({{"componentType":5126,"count":{2},"type":"VEC3"}},)"
      R"({{"componentType":5126,"count":{2},"type":"VEC4"}}],)"
      R"("buffers":[{{"byteLength":{3}}}],"bufferViews":[{{"buffer":0,"byteLength":{3}}}],)"
      R"("meshes":[{{"primitives":[{{"mode":0,"attributes":{{{4}}},"extensions":)"
      R"({{"KHR_gaussian_splatting":{{"extensions":{{"{0}":{{"bufferView":0}}}}}}}}}}]}}],)"
      R"("nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"scene":0}})",
      extension, bounds, count, spz.size(), attributes);
  return make_glb(json, spz);
}

Bytes spz_glb(const SplatCloud& cloud, const Bytes& spz) {
  return spz_glb(spz, cloud.size(), cloud.sh_degree, bounds_of(cloud, false));
}

SpzOptions in_axes_of_the_draft(int version) {
  SpzOptions options{.version = version, .name_axes = false};
  options.axes = SpzAxes::right_up_back;
  return options;
}

struct Fixture {
  SplatCloud cloud;
  Bytes spz, glb;
};

Fixture fixture(std::size_t count = 20, int degree = 2, int version = 3) {
  Fixture f;
  f.cloud = read_as_spz(*encode_spz(spz_cloud(count, degree), "x"))->cloud;
  for (glm::vec3& p : f.cloud.positions) p += glm::vec3(30, 7, -50);  // bounds tell the frame
  f.spz = *encode_spz(f.cloud, "x", in_axes_of_the_draft(version));
  f.glb = spz_glb(f.cloud, f.spz);
  return f;
}

TEST(GlbSpz, HoldsTheSameSceneAsTheSpzItself) {
  for (const int version : {3, 4}) {
    for (const int degree : {0, 1, 2, 3}) {
      const Fixture f = fixture(50, degree, version);
      FLUXGS_UNWRAP(scene, read(f.glb));
      FLUXGS_UNWRAP(alone, read_spz(f.spz, "x", SpzAxes::right_up_back));
      const SpzWorst worst = spz_compare(alone.cloud, scene.cloud);
      EXPECT_EQ(scene.format, "glb");
      EXPECT_EQ(scene.extensions.size(), 2u);
      EXPECT_EQ(
          worst.position + worst.log_scale + worst.opacity + worst.dc + worst.sh1 + worst.sh_rest,
          0);
    }
  }
}

// Left-up-front by the draft, or the stored axes taken for glTF's: the bounds decide.
TEST(GlbSpz, BoundsOfThePositionsTellTheAxes) {
  const Fixture f = fixture();
  const auto first = [&](const std::string& bounds) {
    const auto scene = read(spz_glb(f.spz, f.cloud.size(), f.cloud.sh_degree, bounds));
    EXPECT_TRUE(scene) << scene.error().message();
    return scene ? scene->cloud : f.cloud;
  };
  const glm::vec3 p = f.cloud.positions[0];
  EXPECT_EQ(first(bounds_of(f.cloud, false)).positions[0], p);
  EXPECT_EQ(first("").positions[0], p);
  EXPECT_EQ(first(R"("min":[0,"x",0],"max":[],)").positions[0], p);
  const SplatCloud turned = first(bounds_of(f.cloud, true));
  EXPECT_EQ(turned.positions[0], glm::vec3(-p.x, p.y, -p.z));
  // Half a turn about y: a splat's colour seen along d is what it was along d turned back.
  EXPECT_EQ(turned.sh_rest[0], f.cloud.sh_rest[0]);
  EXPECT_EQ(turned.sh_rest[1], -f.cloud.sh_rest[1]);
  EXPECT_EQ(turned.sh_rest[2], -f.cloud.sh_rest[2]);
}

TEST(GlbSpz, FollowsItsNode) {
  const Fixture f = fixture(10, 1);
  FLUXGS_UNWRAP(scene, read(edited(f.glb, R"({"mesh":0})",
                                   R"({"mesh":0,"translation":[1,2,3],"scale":[2,2,2]})")));
  const glm::vec3 p = f.cloud.positions[4];
  EXPECT_EQ(scene.cloud.positions[4], p * 2.0f + glm::vec3(-1, -2, 3));
  EXPECT_NEAR(scene.cloud.log_scales[4].y, f.cloud.log_scales[4].y + std::log(2.0), 1e-6);
}

TEST(GlbSpz, MayBeShownTwice) {
  const Fixture f = fixture(6, 1);
  const Bytes twice = edited(f.glb, R"("nodes":[{"mesh":0}])",
                             R"("nodes":[{"children":[1,2]},{"mesh":0},{"mesh":0}])");
  FLUXGS_UNWRAP(scene, read(twice));
  EXPECT_EQ(scene.cloud.size(), 12u);
  EXPECT_EQ(scene.cloud.positions[8], f.cloud.positions[2]);
}

TEST(GlbSpz, CountsAndDegreesMustAgree) {
  const Fixture f = fixture();
  const std::string bounds = bounds_of(f.cloud, false);
  const char* place = "meshes[0].primitives[0]: KHR_gaussian_splatting_compression_spz_2: header";
  expect_error(read(spz_glb(f.spz, 21, 2, bounds)), {place, "has 20 splats, but POSITION has 21"});
  expect_error(read(spz_glb(f.spz, 20, 1, bounds)), {place, "has degree 2", "attributes have 1"});
  expect_error(read(spz_glb(f.spz, 20, 3, bounds)), {place, "has degree 2", "attributes have 3"});
  expect_error(read(edited(f.glb, R"("COLOR_0":1)", R"("COLOR_0":9)")),
               {"COLOR_0: accessor 9", "does not exist"});
  expect_error(read(edited(f.glb, R"("POSITION":0)", R"("_OTHER":0)")), {"POSITION is missing"});
  expect_error(read(edited(f.glb, R"("normalized":true,"count":20)", R"("count":19)")),
               {"COLOR_0: accessor 1", "has 19 elements, but POSITION has 20"});
  expect_error(read(edited(f.glb, R"(SH_DEGREE_1_COEF_1)", R"(SH_DEGREE_1_COEF_7)")),
               {"SH_DEGREE_1_COEF_1 is missing"});
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

// Cesium's files of 2025, before the name of today: beside KHR_gaussian_splatting's object or in
// its place, attributes with underscores, harmonics not named.
TEST(GlbSpz, ReadsTheDraftsBeforeIt) {
  const Fixture f = fixture(20, 2);
  const std::string json = json_of(f.glb);
  const auto scene_of = [&](const std::string& text) {
    const auto scene = read(make_glb(text, bin_of(f.glb)));
    EXPECT_TRUE(scene) << scene.error().message();
    return scene ? scene->cloud : SplatCloud{};
  };
  const auto expect_same = [&](const SplatCloud& cloud) {
    EXPECT_EQ(cloud.sh_degree, 2);
    EXPECT_EQ(cloud.positions, f.cloud.positions);
    EXPECT_EQ(cloud.sh_rest, f.cloud.sh_rest);
  };
  const std::string last = "KHR_gaussian_splatting_compression_spz_2";
  expect_same(scene_of(replaced(json, last, "KHR_gaussian_splatting_compression_spz")));
  const std::string nested =
      R"("KHR_gaussian_splatting":{"extensions":{")" + last + R"(":{"bufferView":0}}})";
  ASSERT_NE(json.find(nested), json.npos);
  for (const char* first : {"KHR_spz_gaussian_splats_compression", "KHR_spz_compression"}) {
    std::string alone =
        replaced(json, nested, fmt::format(R"("{}":{{"bufferView":0,"numPoints":20}})", first));
    alone =
        replaced(alone, R"("KHR_gaussian_splatting",")" + last + '"', fmt::format("\"{}\"", first));
    alone = replaced(alone, "KHR_gaussian_splatting:", "_");
    expect_same(scene_of(alone));
    expect_same(scene_of(replaced(alone, "_SH_DEGREE_", "_OTHER_")));
    expect_same(scene_of(
        replaced(json, nested,
                 fmt::format(R"("KHR_gaussian_splatting":{{}},"{}":{{"bufferView":0}})", first))));
  }
  const std::string twice =
      replaced(json, R"("KHR_gaussian_splatting":{"ext)",
               R"("KHR_spz_compression":{"bufferView":0},"KHR_gaussian_splatting":{"ext)");
  expect_error(read(make_glb(twice, bin_of(f.glb))), {"compressed twice"});
}

TEST(GlbSpz, ReferencesAreChecked) {
  const Fixture f = fixture();
  const auto view = [&](const std::string& value) {
    return read(edited(f.glb, R"(_spz_2":{"bufferView":0})", "_spz_2\":" + value));
  };
  expect_error(view(R"({"bufferView":1})"), {"bufferViews[1]", "does not exist"});
  for (const char* wrong : {"{}", "7", "[]", R"({"bufferView":-1})", R"({"bufferView":1.5})",
                            R"({"bufferView":"0"})", R"({"bufferView":4294967296})"}) {
    expect_error(view(wrong), {"compression_spz_2.bufferView", "whole number"});
  }
  const std::string size = std::to_string(f.spz.size());
  expect_error(read(edited(f.glb, R"("bufferViews":[{"buffer":0,"byteLength":)" + size,
                           R"("bufferViews":[{"buffer":0,"byteLength":9999999)")),
               {"bufferViews[0]", "outside the buffer"});
  expect_error(read(edited(f.glb, R"("bufferViews":[{"buffer":0,"byteLength":)" + size,
                           R"("bufferViews":[{"buffer":0,"byteLength":0)")),
               {"spz_2: gzip"});
  expect_error(read(edited(f.glb, R"("KHR_gaussian_splatting":{"ext)",
                           R"("KHR_gaussian_splatting":{"kernel":"disk","ext)")),
               {"kernel", "disk"});
  expect_error(read(edited(f.glb, R"("mode":0)", R"("mode":4)")), {"has mode 4"});
}

TEST(GlbSpz, DamagedDataAreAnErrorOfTheirPlace) {
  for (const int version : {3, 4}) {
    const Fixture f = fixture(5, 1, version);
    for (std::size_t size = 0; size < f.spz.size(); ++size) {
      const Bytes cut(f.spz.begin(), f.spz.begin() + std::ptrdiff_t(size));
      const auto scene = read(spz_glb(cut, 5, 1, ""));
      ASSERT_FALSE(scene) << size;
      // An empty BIN chunk is none, and so a buffer too few.
      if (size > 0) {
        EXPECT_NE(scene.error().field.find("spz_2"), std::string::npos) << size;
      }
    }
  }
}

TEST(GlbSpz, RepeatedMeshesCannotDemandTimeOrMemoryOutOfProportion) {
  const auto shown = [](const Bytes& glb, int times) {
    std::string nodes = R"("nodes":[{"children":[1)";
    for (int i = 2; i <= times; ++i) nodes += fmt::format(",{}", i);
    nodes += "]}";
    for (int i = 0; i < times; ++i) nodes += R"(,{"mesh":0})";
    return read(edited(glb, R"("nodes":[{"mesh":0}])", nodes + "]"));
  };
  // Much data for few splats: decoding takes the time.
  const Fixture f = fixture(20'000, 3);
  EXPECT_TRUE(shown(f.glb, 5));
  expect_error(shown(f.glb, 20), {"nodes", "repeating meshes"});
  // Little data for many splats.
  SplatCloud equal;
  equal.resize(50'000);
  const Bytes small = spz_glb(equal, *encode_spz(equal, "x", {4}));
  EXPECT_LT(small.size(), 4000u);
  EXPECT_TRUE(shown(small, 20));
  expect_error(shown(small, 21), {"nodes", "repeating meshes"});
}

// One splat at (1, 2, 3) in a node that turns glTF's z up into y up. The file's bounds say that the
// stored axes are glTF's.
TEST(GlbSpz, ReadsAFileOfAnotherProgram) {
  const auto path = data_file("splats/spz-gltf-basic/basic.glb");
  if (!path) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
  FLUXGS_UNWRAP(scene, read_glb(*read_file(*path), "basic.glb"));
  ASSERT_EQ(scene.cloud.size(), 1u);
  EXPECT_EQ(scene.cloud.sh_degree, 0);
  EXPECT_EQ(scene.cloud.positions[0], glm::vec3(-1, -3, -2));  // (1, 3, -2) in glTF
  EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(3, 2, 1));
}

}  // namespace
}  // namespace fluxgs
