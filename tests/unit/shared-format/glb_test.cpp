#include <cmath>
#include <limits>

#include "fluxgs/io/file.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "glb_support.h"

namespace fluxgs {
namespace {

using namespace test;

// The largest differences between two clouds; rotations are compared as rotations.
struct Worst {
  double position = 0, log_scale = 0, rotation = 0, opacity = 0, sh = 0;
};

double opacity_of(float logit) { return 1 / (1 + std::exp(-double{logit})); }

double rotation_difference(const glm::quat& a, const glm::quat& b) {
  const glm::dquat p = glm::normalize(glm::dquat(a)), q = glm::normalize(glm::dquat(b));
  return std::min(glm::length(p - q), glm::length(p + q));
}

Worst compare(const SplatCloud& a, const SplatCloud& b) {
  Worst worst;
  EXPECT_EQ(a.size(), b.size());
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  if (a.size() != b.size() || a.sh_degree != b.sh_degree) return worst;
  const auto raise = [](double& to, const glm::vec3& difference) {
    for (int c = 0; c < 3; ++c) to = std::max(to, std::abs(double{difference[c]}));
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    raise(worst.position, a.positions[i] - b.positions[i]);
    raise(worst.log_scale, a.log_scales[i] - b.log_scales[i]);
    raise(worst.sh, a.sh_dc[i] - b.sh_dc[i]);
    worst.rotation = std::max(worst.rotation, rotation_difference(a.rotations[i], b.rotations[i]));
    worst.opacity = std::max(
        worst.opacity, std::abs(opacity_of(a.opacity_logits[i]) - opacity_of(b.opacity_logits[i])));
  }
  for (std::size_t i = 0; i < a.sh_rest.size(); ++i) raise(worst.sh, a.sh_rest[i] - b.sh_rest[i]);
  return worst;
}

void print(const char* what, const Worst& w) {
  std::printf("%s: position %.1e, log-scale %.1e, rotation %.1e, opacity %.1e, SH %.1e\n", what,
              w.position, w.log_scale, w.rotation, w.opacity, w.sh);
}

TEST(Glb, RoundTripWithinFloat) {
  for (const int degree : {0, 1, 2, 3}) {
    for (const std::size_t count : {1, 1000}) {
      const SplatCloud cloud = random_cloud(count, degree, 11);
      FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x.glb"));
      FLUXGS_UNWRAP(scene, read_glb(bytes, "x.glb"));
      const Worst worst = compare(cloud, scene.cloud);
      if (degree == 3 && count > 1) print("glb round trip", worst);
      EXPECT_EQ(worst.position, 0);  // only signs change
      EXPECT_EQ(worst.sh, 0);
      EXPECT_LT(worst.log_scale, 2e-6);
      EXPECT_LT(worst.rotation, 2e-7);
      EXPECT_LT(worst.opacity, 1e-7);
      EXPECT_EQ(scene.format, "glb");
      EXPECT_EQ(scene.extensions, std::vector<std::string>{"KHR_gaussian_splatting"});
    }
  }
}

TEST(Glb, ASecondRoundTripChangesNoPositionsAndNoBands) {
  FLUXGS_UNWRAP(first, encode_glb(random_cloud(50, 3), "x"));
  FLUXGS_UNWRAP(once, read(first));
  FLUXGS_UNWRAP(second, encode_glb(once.cloud, "x"));
  FLUXGS_UNWRAP(twice, read(second));
  const Worst worst = compare(once.cloud, twice.cloud);
  EXPECT_EQ(worst.position + worst.sh, 0);
  EXPECT_LT(worst.log_scale + worst.rotation + worst.opacity, 1e-5);
}

TEST(Glb, EmptySceneIsAValidFile) {
  SplatCloud cloud;
  cloud.sh_degree = 3;
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x.glb"));
  FLUXGS_UNWRAP(scene, read(bytes));
  EXPECT_EQ(scene.cloud.size(), 0u);
}

TEST(Glb, EndsOfTheRangeStayFinite) {
  SplatCloud cloud = random_cloud(1, 0);
  cloud.opacity_logits[0] = 40;  // rounds to 1
  cloud.log_scales[0] = {-200, 200, 15};
  cloud.rotations[0] = glm::quat(0, 0, 0, 0);
  FLUXGS_UNWRAP(high_bytes, encode_glb(cloud, "x"));
  FLUXGS_UNWRAP(high, read(high_bytes));
  EXPECT_EQ(high.dropped, 0u);
  EXPECT_NEAR(high.cloud.opacity_logits[0], 17.33, 0.01);
  EXPECT_NEAR(high.cloud.log_scales[0].x, -87.34, 0.01);
  EXPECT_NEAR(high.cloud.log_scales[0].y, 88.72, 0.01);
  EXPECT_NEAR(high.cloud.log_scales[0].z, 15, 1e-6);
  EXPECT_LT(rotation_difference(high.cloud.rotations[0], glm::quat(1, 0, 0, 0)), 1e-7);
  cloud.opacity_logits[0] = -500;
  FLUXGS_UNWRAP(low_bytes, encode_glb(cloud, "x"));
  FLUXGS_UNWRAP(low, read(low_bytes));
  EXPECT_NEAR(low.cloud.opacity_logits[0], -87.34, 0.01);
  cloud.opacity_logits[0] = -30;
  FLUXGS_UNWRAP(small_bytes, encode_glb(cloud, "x"));
  FLUXGS_UNWRAP(small, read(small_bytes));
  EXPECT_NEAR(small.cloud.opacity_logits[0], -30, 1e-5);
}

TEST(Glb, WritesWhatTheSpecificationAsks) {
  SplatCloud cloud = random_cloud(3, 1);
  cloud.positions = {{1, 2, 3}, {-4, 5, -6}, {7, -8, 9}};
  cloud.rotations[0] = glm::quat(2, 0, 0, 0);
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  const std::string json = json_of(bytes);
  for (const char* part :
       {R"("extensionsUsed":["KHR_gaussian_splatting"])", R"("mode":0)", R"("kernel":"ellipse")",
        R"("colorSpace":"srgb_rec709_display")", R"("min":[-7.0,-5.0,-6.0])",
        R"("max":[4.0,8.0,9.0])", R"("nodes":[{"mesh":0}])", R"("scenes":[{"nodes":[0]}])",
        R"("scene":0)", R"("version":"2.0")", R"("normalized":true)",
        R"("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2":)"}) {
    EXPECT_NE(json.find(part), std::string::npos) << part << " in " << json;
  }
  EXPECT_EQ(bytes.size() % 4, 0u);
  // Stored rotations are unit (w x y z = 2 0 0 0, turned: x y z w = 0 0 1 0).
  const Bytes bin = bin_of(bytes);
  float rotation[4];
  std::memcpy(rotation, bin.data() + 3 * 16, sizeof rotation);
  EXPECT_EQ(std::abs(rotation[2]), 1);
  EXPECT_EQ(rotation[3], 0);
}

// COLOR_0 is linear: mid-grey 0.5 in sRGB is 0.214.
TEST(Glb, FallbackColourIsLinear) {
  SplatCloud cloud = random_cloud(1, 0);
  cloud.sh_dc[0] = {0, 10, -10};
  cloud.opacity_logits[0] = 0;
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  const Bytes bin = bin_of(bytes);
  EXPECT_EQ(int(bin[12]), 55);
  EXPECT_EQ(int(bin[13]), 255);
  EXPECT_EQ(int(bin[14]), 0);
  EXPECT_EQ(int(bin[15]), 128);
}

TEST(Glb, AgreesWithAnIndependentWriter) {
  const auto ply = data_file("splats/plush-dog/point_cloud_29999_clean.ply");
  const auto glb = data_file("splats/plush-dog/converted/plush-dog.glb");
  if (!ply || !glb) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
  FLUXGS_UNWRAP(ply_bytes, read_file(*ply));
  FLUXGS_UNWRAP(glb_bytes, read_file(*glb));
  FLUXGS_UNWRAP(original, read_ply(ply_bytes, ply->string()));
  FLUXGS_UNWRAP(converted, read_glb(glb_bytes, glb->string()));
  const Worst worst = compare(original.cloud, converted.cloud);
  print("plush-dog .ply against splat-transform's .glb", worst);
  EXPECT_EQ(worst.position, 0);
  EXPECT_LT(worst.log_scale, 2e-6);
  EXPECT_LT(worst.rotation, 1e-6);
  EXPECT_LT(worst.opacity, 1e-6);
  EXPECT_LT(worst.sh, 1e-6);
  FLUXGS_UNWRAP(own_bytes, encode_glb(original.cloud, "own.glb"));
  FLUXGS_UNWRAP(own, read(own_bytes));
  print("plush-dog .ply against our .glb", compare(original.cloud, own.cloud));
  EXPECT_LT(compare(own.cloud, converted.cloud).rotation, 1e-6);
}

// Two splats with integer attributes of every kind that the specification allows.
TEST(Glb, ReadsQuantizedAttributes) {
  Bytes bin;
  const auto put = [&](std::initializer_list<int> values, std::size_t bytes_each) {
    for (const int v : values) {
      const auto* raw = reinterpret_cast<const std::byte*>(&v);
      bin.insert(bin.end(), raw, raw + bytes_each);
    }
  };
  put({1, -2, 3, 0, -4, 5, -6, 0}, 2);      // 0: POSITION, short, stride 8
  put({0, 0, 0, 127, 127, 0, 0, -128}, 1);  // 16: ROTATION, normalised byte
  put({1, 2, 3, 0, 255, 128, 0, 0}, 1);     // 24: SCALE, unsigned byte, stride 4
  put({0, 65535}, 2);                       // 32: OPACITY, normalised ushort
  for (const float f : {0.5f, 0.25f, -1.0f, 1.0f, 2.0f, 3.0f}) append(bin, f);  // 36: SH 0
  const auto document = [](bool scale_normalized) {
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_gaussian_splatting","KHR_mesh_quantization"],
"extensionsRequired":["KHR_mesh_quantization"],"buffers":[{{"byteLength":60}}],
"bufferViews":[{{"buffer":0,"byteLength":16,"byteStride":8}},{{"buffer":0,"byteOffset":16,"byteLength":8}},
{{"buffer":0,"byteOffset":24,"byteLength":8,"byteStride":4}},{{"buffer":0,"byteOffset":32,"byteLength":4}},
{{"buffer":0,"byteOffset":36,"byteLength":24}}],
"accessors":[{{"bufferView":0,"componentType":5122,"count":2,"type":"VEC3"}},
{{"bufferView":1,"componentType":5120,"normalized":true,"count":2,"type":"VEC4"}},
{{"bufferView":2,"componentType":5121,"normalized":{},"count":2,"type":"VEC3"}},
{{"bufferView":3,"componentType":5123,"normalized":true,"count":2,"type":"SCALAR"}},
{{"bufferView":4,"componentType":5126,"count":2,"type":"VEC3"}}],
"meshes":[{{"primitives":[{{"mode":0,"attributes":{{"POSITION":0,"KHR_gaussian_splatting:ROTATION":1,
"KHR_gaussian_splatting:SCALE":2,"KHR_gaussian_splatting:OPACITY":3,"KHR_gaussian_splatting:SH_DEGREE_0_COEF_0":4}},
"extensions":{{"KHR_gaussian_splatting":{{"kernel":"ellipse","colorSpace":"srgb_rec709_display"}}}}}}]}}],
"nodes":[{{"mesh":0}}]}})",
        scale_normalized);
  };
  FLUXGS_UNWRAP(scene, read(make_glb(document(false), bin)));
  ASSERT_EQ(scene.cloud.size(), 2u);
  EXPECT_EQ(scene.cloud.positions[0], glm::vec3(-1, 2, 3));
  EXPECT_EQ(scene.cloud.positions[1], glm::vec3(4, -5, -6));
  EXPECT_FLOAT_EQ(scene.cloud.log_scales[0].z, std::log(3.0f));
  EXPECT_FLOAT_EQ(scene.cloud.log_scales[1].x, std::log(255.0f));
  EXPECT_NEAR(scene.cloud.log_scales[1].z, -87.34, 0.01);
  EXPECT_NEAR(scene.cloud.opacity_logits[0], -87.34, 0.01);
  EXPECT_NEAR(scene.cloud.opacity_logits[1], 17.33, 0.01);
  EXPECT_EQ(scene.cloud.sh_dc[1], glm::vec3(1, 2, 3));
  // Identity in glTF is half a turn about z here; −128 counts as −1.
  EXPECT_LT(rotation_difference(scene.cloud.rotations[0], glm::quat(0, 0, 0, 1)), 1e-6);
  EXPECT_LT(rotation_difference(scene.cloud.rotations[1], glm::quat(0, 0, -1, 1)), 1e-6);
  FLUXGS_UNWRAP(normalised, read(make_glb(document(true), bin)));
  EXPECT_FLOAT_EQ(normalised.cloud.log_scales[1].x, 0);
  EXPECT_FLOAT_EQ(normalised.cloud.log_scales[1].y, std::log(128 / 255.0f));
}

TEST(Glb, ConcatenatesPrimitivesAndPadsBands) {
  const SplatCloud cloud = random_cloud(5, 1, 31);
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  // A second mesh: the same splats without their first degree.
  std::string json = json_of(bytes);
  const std::size_t begin = json.find(R"("primitives":[)") + 14, end = json.find("]}],\"nodes\"");
  ASSERT_NE(end, std::string::npos) << json;
  std::string plain = json.substr(begin, end - begin);
  for (int i = 0; i < 3; ++i) {
    const std::size_t at =
        plain.find(fmt::format("\"KHR_gaussian_splatting:SH_DEGREE_1_COEF_{}\":", i));
    ASSERT_NE(at, std::string::npos);
    plain.erase(at,
                plain.find_first_of(",}", at) - at + (plain[plain.find_first_of(",}", at)] == ','));
  }
  if (const std::size_t comma = plain.find(",}"); comma != std::string::npos) plain.erase(comma, 1);
  json.insert(end + 2, R"(,{"primitives":[)" + plain + "]}");
  const Bytes two = edited(make_glb(json, bin_of(bytes)), R"("nodes":[{"mesh":0}])",
                           R"("nodes":[{"children":[1],"mesh":1},{"mesh":0}])");
  FLUXGS_UNWRAP(scene, read(two));
  ASSERT_EQ(scene.cloud.size(), 10u);
  EXPECT_EQ(scene.cloud.sh_degree, 1);
  EXPECT_EQ(scene.cloud.positions[7], cloud.positions[2]);
  EXPECT_EQ(scene.cloud.positions[2], cloud.positions[2]);
  EXPECT_EQ(scene.cloud.sh_rest[2 * 3 + 1], glm::vec3(0));
  EXPECT_EQ(scene.cloud.sh_rest[7 * 3 + 1], cloud.sh_rest[2 * 3 + 1]);
}

// A draft of the extension stored logarithms, and splat-transform wrote them until its version 2.6.
TEST(Glb, NegativeScalesAreLogarithms) {
  using nlohmann::json;
  const SplatCloud cloud = random_cloud(30, 0, 4);
  const auto file = encode_glb(cloud, "logs.glb");
  ASSERT_TRUE(file) << file.error().message();
  const json root = json::parse(json_of(*file));
  const int accessor =
      root["meshes"][0]["primitives"][0]["attributes"]["KHR_gaussian_splatting:SCALE"];
  const json& view = root["bufferViews"][root["accessors"][accessor]["bufferView"].get<int>()];
  const std::size_t first = view.value("byteOffset", std::size_t{0}) +
                            root["accessors"][accessor].value("byteOffset", std::size_t{0});
  const std::size_t stride = view.value("byteStride", std::size_t{12});
  Bytes bin = bin_of(*file);
  for (std::size_t i = 0; i < 30; ++i) {
    const glm::vec3 logs = glm::vec3(-4, -5, -0.5f * static_cast<float>(i));
    std::memcpy(bin.data() + first + i * stride, &logs, sizeof logs);
  }
  const auto scene = read_glb(make_glb(json_of(*file), bin), "logs.glb");
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->dropped, 0u);
  for (std::size_t i = 0; i < 30; ++i)
    EXPECT_EQ(scene->cloud.log_scales[i], glm::vec3(-4, -5, -0.5f * static_cast<float>(i)));
}

/// A scene whose opacities 3 and 7 are replaced by those of a sparse accessor, and whose second
/// coefficient of SH is zeros without data.
Bytes sparse_glb(const SplatCloud& cloud, std::uint16_t second_index) {
  using nlohmann::json;
  const auto file = encode_glb(cloud, "sparse.glb");
  EXPECT_TRUE(file) << file.error().message();
  json root = json::parse(json_of(*file));
  Bytes bin = bin_of(*file);
  const json attributes = root["meshes"][0]["primitives"][0]["attributes"];
  const std::size_t begin = bin.size();
  append(bin, std::uint16_t{3});
  append(bin, second_index);
  append(bin, 0.9f);
  append(bin, 0.25f);
  const std::size_t view = root["bufferViews"].size();
  root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", 4}});
  root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin + 4}, {"byteLength", 8}});
  root["buffers"][0]["byteLength"] = bin.size();
  const int opacity = attributes["KHR_gaussian_splatting:OPACITY"];
  root["accessors"][opacity]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", view}, {"componentType", 5123}}},
      {"values", {{"bufferView", view + 1}}}};
  const int band = attributes["KHR_gaussian_splatting:SH_DEGREE_1_COEF_1"];
  root["accessors"][band].erase("bufferView");
  root["accessors"][band].erase("byteOffset");
  return make_glb(root.dump(), bin);
}

TEST(Glb, SparseAccessorsAndZeros) {
  const SplatCloud cloud = random_cloud(20, 1, 9);
  const auto plain = read_glb(*encode_glb(cloud, "plain.glb"), "plain.glb");
  const auto scene = read_glb(sparse_glb(cloud, 7), "sparse.glb");
  ASSERT_TRUE(scene) << scene.error().message();
  for (std::size_t i = 0; i < 20; ++i) {
    const float opacity = i == 3   ? std::log(9.0f)
                          : i == 7 ? -std::log(3.0f)
                                   : plain->cloud.opacity_logits[i];
    EXPECT_NEAR(scene->cloud.opacity_logits[i], opacity, 1e-5) << i;
    EXPECT_EQ(scene->cloud.sh_rest[3 * i], plain->cloud.sh_rest[3 * i]);
    EXPECT_EQ(scene->cloud.sh_rest[3 * i + 1], glm::vec3(0));
  }
  expect_error(read_glb(sparse_glb(cloud, 20), "sparse.glb"), {"OPACITY", "element 20 of 20"});
}

TEST(Glb, NamesOfDraftsAreKnown) {
  const Bytes bytes = small_glb(3, 1);
  const std::string space = R"("colorSpace":"srgb_rec709_display")";
  for (const char* name : {R"("colorSpace":"BT.709-srgb")", R"("colorSpace":"BT.709")", R"("a":0)"})
    EXPECT_TRUE(read(edited(bytes, space, name))) << name;
  EXPECT_TRUE(read(edited(bytes, R"("kernel":"ellipse",)", "")));
  FLUXGS_UNWRAP(underscored, read(edited(edited(bytes, "KHR_gaussian_splatting:SCALE", "_SCALE"),
                                         "KHR_gaussian_splatting:ROTATION", "_ROTATION")));
  EXPECT_EQ(underscored.cloud.size(), 3u);
}

double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

TEST(Glb, LinearColoursBecomeSrgb) {
  for (const char* name : {"lin_rec709_display", "BT.709-linear", "linear"}) {
    SplatCloud cloud = random_cloud(30, 0, 5);
    FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
    FLUXGS_UNWRAP(scene, read(edited(bytes, "srgb_rec709_display", name)));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("linear"), std::string::npos);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const double linear = std::max(math::kSh0 * double{cloud.sh_dc[i][c]} + 0.5, 0.0);
        EXPECT_NEAR(math::kSh0 * double{scene.cloud.sh_dc[i][c]} + 0.5, encoded(linear), 1e-6);
      }
  }
  // Harmonics that stay within 0.3…0.7: the encoded colours are nearly harmonics, too
  SplatCloud cloud = random_cloud(30, 2, 6);
  for (glm::vec3& dc : cloud.sh_dc) dc = glm::vec3(0);
  for (glm::vec3& band : cloud.sh_rest) band *= 0.02f / std::max(0.02f, glm::length(band));
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  FLUXGS_UNWRAP(scene, read(edited(bytes, "srgb_rec709_display", "lin_rec709_display")));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 d = glm::normalize(glm::dvec3(0.3 * double(i) - 4, 1, -2));
    const glm::dvec3 linear = colour(cloud, i, d) + 0.5, shown = colour(scene.cloud, i, d) + 0.5;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[c], encoded(linear[c]), 2e-3);
  }
}

TEST(Glb, CarriesTheScreenFilter) {
  SplatCloud cloud = random_cloud(4, 1);
  FLUXGS_UNWRAP(classic, encode_glb(cloud, "x"));
  EXPECT_EQ(json_of(classic).find("screenFilter"), std::string::npos);
  cloud.filter = {0.1f, true};
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  FLUXGS_UNWRAP(scene, read(bytes));
  EXPECT_EQ(scene.cloud.filter, cloud.filter);
  EXPECT_TRUE(scene.warnings.empty());
  FLUXGS_UNWRAP(plain, read(classic));
  EXPECT_EQ(plain.cloud.filter, ScreenFilter{});
}

TEST(Glb, ScreenFiltersOutOfRangeAreReplacedWithAWarning) {
  SplatCloud cloud = random_cloud(4, 1);
  cloud.filter = {0.5f, true};
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  for (const char* wrong :
       {"0", "-1", "0.0", "1e9", "1e-300", "\"NaN\"", "null", "[0.3]", "true"}) {
    FLUXGS_UNWRAP(scene,
                  read(edited(bytes, R"("dilation":0.5)", fmt::format(R"("dilation":{})", wrong))));
    EXPECT_EQ(scene.cloud.filter, (ScreenFilter{0.3, true})) << wrong;
    EXPECT_EQ(scene.warnings.size(), 1u) << wrong;
  }
  FLUXGS_UNWRAP(scene, read(edited(bytes, R"("compensated":true)", R"("compensated":1)")));
  EXPECT_EQ(scene.cloud.filter, (ScreenFilter{0.5, false}));
  EXPECT_EQ(scene.warnings.size(), 1u);
  // A member of another kind is none
  FLUXGS_UNWRAP(none, read(edited(bytes, R"("screenFilter":{)", R"("screenFilter":7,"was":{)")));
  EXPECT_EQ(none.cloud.filter, ScreenFilter{});
  SplatCloud other = cloud;
  other.filter = {};
  other.filter.dilation = 0.2f;
  FLUXGS_UNWRAP(two, read(joined_glb({bytes, *encode_glb(other, "y")})));
  EXPECT_EQ(two.cloud.filter, cloud.filter);
  EXPECT_EQ(two.warnings.size(), 1u);
}

TEST(Glb, QuantizedAttributesKeepWithinHalfALevel) {
  for (const int bits : {8, 16}) {
    for (const int degree : {0, 3}) {
      SplatCloud cloud = random_cloud(2000, degree, 12);
      // Sizes from dust to sky, needles and planes
      for (std::size_t i = 0; i < cloud.size(); ++i)
        cloud.log_scales[i] += glm::vec3(-12.0f + 0.01f * static_cast<float>(i));
      cloud.log_scales[7] = {3, -60, -60};
      cloud.log_scales[8] = {-300, -300, -300};
      cloud.filter = {0.1f, true};
      const GlbOptions options{bits};
      FLUXGS_UNWRAP(bytes, encode_glb(cloud, options, "x"));
      FLUXGS_UNWRAP(scene, read(bytes));
      const std::vector<std::uint32_t> order = glb_order(cloud, options);
      ASSERT_EQ(order.size(), cloud.size());
      ASSERT_EQ(scene.cloud.size(), cloud.size());
      EXPECT_EQ(scene.cloud.filter, cloud.filter);
      EXPECT_EQ(scene.dropped, 0u);
      const SplatCloud expected = in_order(cloud, order);
      EXPECT_EQ(scene.cloud.positions, expected.positions);  // scaled by powers of two
      EXPECT_EQ(scene.cloud.sh_dc, expected.sh_dc);
      EXPECT_EQ(scene.cloud.sh_rest, expected.sh_rest);
      const double unsigned_levels = bits == 8 ? 255 : 65535, levels = bits == 8 ? 127 : 32767;
      // A node's scale is at most 4 or 256 times the size of its splats, but for the few of
      // kMinClass
      const double coarsest = bits == 8 ? 4 : 256;
      std::size_t coarse = 0;
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        EXPECT_LE(std::abs(opacity_of(scene.cloud.opacity_logits[i]) -
                           opacity_of(expected.opacity_logits[i])),
                  0.5 / unsigned_levels + 1e-7);
        EXPECT_LE(rotation_difference(scene.cloud.rotations[i], expected.rotations[i]),
                  2 * 0.5 / levels * 1.001);
        const glm::vec3 &s = expected.log_scales[i], &got = scene.cloud.log_scales[i];
        const double size = std::exp(double{std::max({s.x, s.y, s.z})});
        for (int c = 0; c < 3; ++c) {
          EXPECT_TRUE(std::isfinite(got[c]));
          const double off = std::abs(std::exp(double{got[c]}) - std::exp(double{s[c]}));
          coarse += off > 1.001 * coarsest / unsigned_levels * size;
        }
      }
      EXPECT_LE(coarse, 3u * 64u);
      const auto bits_of = scene.attribute_bits;
      EXPECT_EQ(bits_of.at("rotation"), 4 * bits);
      EXPECT_EQ(bits_of.at("position"), 96);
      EXPECT_EQ(json_of(bytes).find("extensionsRequired"), std::string::npos);
    }
  }
  // Splats that differ less make a smaller file
  const SplatCloud ordinary = random_cloud(2000, 0, 13);
  const std::size_t floats = encode_glb(ordinary, "x")->size();
  EXPECT_LT(encode_glb(ordinary, GlbOptions{16}, "x")->size(), 0.9 * double(floats));
  EXPECT_LT(encode_glb(ordinary, GlbOptions{8}, "x")->size(), 0.85 * double(floats));
  EXPECT_FALSE(encode_glb(random_cloud(3, 0), GlbOptions{12}, "x"));
  FLUXGS_UNWRAP(none, encode_glb(SplatCloud{}, GlbOptions{8}, "x"));
  EXPECT_TRUE(read(none));
  EXPECT_EQ(*encode_glb(random_cloud(9, 1), GlbOptions{}, "x"),
            *encode_glb(random_cloud(9, 1), "x"));
}

TEST(Glb, OtherContentIsIgnored) {
  const Bytes bytes = small_glb();
  const Bytes busy = edited(
      bytes, R"("meshes":[)",
      R"("images":[{"bufferView":77,"mimeType":"image/png"}],"materials":[{"name":"m","pbrMetallicRoughness":{"baseColorTexture":{"index":5}}}],)"
      R"("textures":[{"source":9}],"animations":[{"channels":[],"samplers":[]}],"skins":[{"joints":[9]}],"cameras":[{"type":"perspective"}],)"
      R"("extras":{"a":[1,{"b":null}]},"extensions":{"VENDOR_x":{"y":1}},"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":99}]},)");
  FLUXGS_UNWRAP(scene,
                read(edited(busy, R"("nodes":[{"mesh":0}])",
                            R"("nodes":[{"mesh":1,"skin":0,"extras":{},"name":"n"},{"mesh":0}])")));
  EXPECT_EQ(scene.cloud.size(), 2u);
  // Only the default scene counts.
  FLUXGS_UNWRAP(none, read(edited(bytes, R"("scenes":[{"nodes":[0]}])", R"("scenes":[{}])")));
  EXPECT_EQ(none.cloud.size(), 0u);
}

TEST(Glb, NonFiniteAndInvalidSplatsAreDroppedAndCounted) {
  const SplatCloud cloud = random_cloud(6, 1);
  FLUXGS_UNWRAP(bytes, encode_glb(cloud, "x"));
  Bytes bin = bin_of(bytes);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float negative = -1;
  std::memcpy(&bin[0], &nan, 4);                     // POSITION of splat 0
  std::memcpy(&bin[6 * 16 + 1 * 16], &nan, 4);       // ROTATION of 1
  std::memcpy(&bin[6 * 32 + 2 * 12], &negative, 4);  // SCALE of 2: invalid
  std::memcpy(&bin[6 * 44 + 3 * 4], &nan, 4);        // OPACITY of 3
  FLUXGS_UNWRAP(scene, read(make_glb(json_of(bytes), bin)));
  EXPECT_EQ(scene.dropped, 4u);
  ASSERT_EQ(scene.cloud.size(), 2u);
  EXPECT_EQ(scene.cloud.positions[0], cloud.positions[4]);
  SplatCloud broken = cloud;
  broken.sh_dc[5].x = nan;
  FLUXGS_UNWRAP(clean, encode_glb(broken, "x"));
  FLUXGS_UNWRAP(left, read(clean));
  EXPECT_EQ(left.cloud.size(), 5u);
}

}  // namespace
}  // namespace fluxgs
