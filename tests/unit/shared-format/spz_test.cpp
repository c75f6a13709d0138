#include "fluxgs/io/spz.h"

#include <array>
#include <limits>
#include <random>

#include "fluxgs/io/file.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "shared-format/src/io/spz/spz_layout.h"
#include "spz_support.h"

namespace fluxgs {
namespace {

using namespace test;

// One splat of degree 1; the same bytes in all versions but for two.
const Bytes kFixed = raw({0x00, 0x10, 0x00, 0x00, 0x20, 0x00, 0x00, 0xd0, 0xff});  // 1, 2, -3
const Bytes kHalves = raw({0x00, 0x3c, 0x00, 0x40, 0x00, 0xc2});                   // 1, 2, -3
const Bytes kAlpha = raw({51});                                                    // 0.2
const Bytes kColour = raw({255, 0, 51});
const Bytes kScale = raw({160, 0, 255});
const Bytes kThree = raw({204, 51, 153});  // x 0.6, y -0.6, z 0.2
const Bytes kSh = raw({192, 128, 64, 64, 128, 192, 255, 0, 160});

// Largest w; x +511, y -256, z +0 of 511, in units of 1/√2.
Bytes smallest_three() {
  Bytes bytes;
  append(bytes, std::uint32_t{3u << 30 | 511u << 20 | (512u | 256u) << 10 | 0u});
  return bytes;
}

Bytes known_file(std::uint32_t version) {
  const Bytes rotation = version >= 3 ? smallest_three() : kThree;
  if (version == 4) return spz4(1, 1, {kFixed, kAlpha, kColour, kScale, rotation, kSh});
  return gzip(joined({spz_header(version, 1, 1), version == 1 ? kHalves : kFixed, kAlpha, kColour,
                      kScale, rotation, kSh}));
}

// `s` is the sign of y and z against what is stored.
void expect_known_values(std::uint32_t version, SpzAxes axes, float s) {
  const Bytes file = known_file(version);
  ASSERT_TRUE(is_spz(file));
  FLUXGS_UNWRAP(scene, read_spz(file, "known.spz", axes));
  const SplatCloud& cloud = scene.cloud;
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(scene.format, "spz");
  EXPECT_EQ(scene.bytes, file.size());
  EXPECT_EQ(cloud.sh_degree, 1);
  EXPECT_EQ(cloud.positions[0], glm::vec3(1, 2 * s, -3 * s));
  EXPECT_NEAR(cloud.opacity_logits[0], std::log(0.2 / 0.8), 1e-6);
  EXPECT_NEAR(cloud.sh_dc[0].x, 0.5 / 0.15, 1e-6);
  EXPECT_NEAR(cloud.sh_dc[0].y, -0.5 / 0.15, 1e-6);
  EXPECT_NEAR(cloud.sh_dc[0].z, -0.3 / 0.15, 1e-6);
  EXPECT_EQ(cloud.log_scales[0], glm::vec3(0, -10, 5.9375f));
  const glm::quat q = cloud.rotations[0];
  if (version < 3) {
    EXPECT_NEAR(q.x, 0.6, 1e-6);
    EXPECT_NEAR(q.y, -0.6 * s, 1e-6);
    EXPECT_NEAR(q.z, 0.2 * s, 1e-6);
    EXPECT_NEAR(q.w, std::sqrt(1 - 0.36 - 0.36 - 0.04), 1e-6);
  } else {
    const double h = std::sqrt(0.5), y = h * 256 / 511;
    EXPECT_NEAR(q.x, h, 1e-6);
    EXPECT_NEAR(q.y, -y * s, 1e-6);
    EXPECT_EQ(q.z, 0);
    EXPECT_NEAR(q.w, std::sqrt(1 - h * h - y * y), 1e-6);
  }
  // The basis functions of degree 1 go with y, z, x.
  EXPECT_EQ(cloud.sh_rest[0], glm::vec3(0.5f, 0, -0.5f) * s);
  EXPECT_EQ(cloud.sh_rest[1], glm::vec3(-0.5f, 0, 0.5f) * s);
  EXPECT_EQ(cloud.sh_rest[2], glm::vec3(127 / 128.0f, -1, 0.25f));
}

TEST(Spz, KnownValuesOfEveryVersion) {
  for (const std::uint32_t version : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(version);
    expect_known_values(version, SpzAxes::right_down_front, 1);
    expect_known_values(version, SpzAxes::right_up_back, -1);
  }
}

TEST(Spz, RoundTripWithinQuantization) {
  for (const int degree : {0, 1, 2, 3}) {
    const SplatCloud cloud = spz_cloud(3000, degree);
    for (const SpzOptions& options :
         {SpzOptions{}, SpzOptions{4}, SpzOptions{3, 16, 8, 8}, SpzOptions{4, 7, 1, 1}}) {
      FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x.spz", options));
      FLUXGS_UNWRAP(scene, read_as_spz(bytes));
      expect_within(fmt::format("degree {} version {}", degree, options.version).c_str(),
                    spz_compare(cloud, scene.cloud),
                    spz_allowed(options.fractional_bits, options.sh1_bits, options.sh_rest_bits));
    }
  }
}

TEST(Spz, ASecondRoundTripChangesNothing) {
  for (const int version : {3, 4}) {
    const SpzOptions options{version};
    FLUXGS_UNWRAP(first, encode_spz(spz_cloud(2000, 3), "x", options));
    FLUXGS_UNWRAP(once, read_as_spz(first));
    FLUXGS_UNWRAP(second, encode_spz(once.cloud, "x", options));
    FLUXGS_UNWRAP(twice, read_as_spz(second));
    const SpzWorst worst = spz_compare(once.cloud, twice.cloud);
    EXPECT_EQ(worst.position + worst.log_scale + worst.dc + worst.sh1 + worst.sh_rest, 0);
    EXPECT_LT(worst.opacity, 1e-7);
    // Where two components are the largest within a step, they may change places.
    EXPECT_LT(worst.rotation, 1e-3);
    FLUXGS_UNWRAP(again, encode_spz(once.cloud, "x", options));
    EXPECT_EQ(again, second);
  }
}

TEST(Spz, VersionsHoldTheSameScene) {
  const SplatCloud cloud = spz_cloud(500, 2);
  FLUXGS_UNWRAP(three, encode_spz(cloud, "x"));
  FLUXGS_UNWRAP(four, encode_spz(cloud, "x", {4}));
  EXPECT_EQ(three[0], std::byte{0x1f});
  EXPECT_EQ(text_of(std::span(four).first(4)), "NGSP");
  FLUXGS_UNWRAP(a, read_as_spz(three));
  FLUXGS_UNWRAP(b, read_as_spz(four));
  const SpzWorst worst = spz_compare(a.cloud, b.cloud);
  EXPECT_EQ(worst.position + worst.log_scale + worst.rotation + worst.opacity + worst.dc +
                worst.sh1 + worst.sh_rest,
            0);
}

TEST(Spz, AxesOfTheSpecificationOnRequest) {
  const SplatCloud cloud = spz_cloud(100, 3);
  SpzOptions options{.name_axes = false};
  options.axes = SpzAxes::right_up_back;
  FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x", options));
  FLUXGS_UNWRAP(scene, read_spz(bytes, "x", SpzAxes::right_up_back));
  expect_within("right-up-back", spz_compare(cloud, scene.cloud), spz_allowed());
  FLUXGS_UNWRAP(turned, read_spz(bytes, "x"));
  EXPECT_EQ(turned.cloud.positions[7] * glm::vec3(1, -1, -1), scene.cloud.positions[7]);
}

TEST(Spz, EmptyScenes) {
  SplatCloud cloud;
  cloud.sh_degree = 2;
  for (const int version : {3, 4}) {
    FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x", {version}));
    FLUXGS_UNWRAP(scene, read_as_spz(bytes));
    EXPECT_EQ(scene.cloud.size(), 0u);
    EXPECT_EQ(scene.cloud.sh_degree, 2);
  }
}

TEST(Spz, EndsOfTheRangeStayFinite) {
  SplatCloud cloud = spz_cloud(2, 1);
  cloud.opacity_logits = {60, -60};
  cloud.log_scales = {glm::vec3(100), glm::vec3(-100)};
  cloud.sh_dc = {glm::vec3(50), glm::vec3(-50)};
  cloud.sh_rest[0] = glm::vec3(7);
  cloud.sh_rest[3] = glm::vec3(-7);
  cloud.rotations = {glm::quat(0, 0, 0, 0), glm::quat(-1e-30f, 0, 0, 0)};
  for (int round = 0; round < 2; ++round) {
    FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x"));
    FLUXGS_UNWRAP(scene, read_as_spz(bytes));
    cloud = scene.cloud;
    EXPECT_EQ(scene.dropped, 0u);
    EXPECT_NEAR(cloud.opacity_logits[0], 17.33, 0.01);
    EXPECT_NEAR(cloud.opacity_logits[1], -87.34, 0.01);
    EXPECT_EQ(cloud.log_scales[0], glm::vec3(5.9375f));
    EXPECT_EQ(cloud.log_scales[1], glm::vec3(-10));
    EXPECT_NEAR(cloud.sh_dc[0].x, 0.5 / 0.15, 1e-6);
    EXPECT_EQ(cloud.sh_rest[0], glm::vec3(127 / 128.0f));
    EXPECT_EQ(cloud.sh_rest[3], glm::vec3(-1));
    for (const glm::quat& q : cloud.rotations) EXPECT_EQ(std::abs(q.w), 1);
  }
}

TEST(Spz, WideScenesGetFewerFractionalBits) {
  const auto bits_for = [&](float farthest, int wanted) {
    SplatCloud cloud = spz_cloud(400, 0);
    for (glm::vec3& p : cloud.positions) p *= farthest / 20;  // at most 20 before
    cloud.positions[1].z = farthest;
    const auto bytes = encode_spz(cloud, "x", {4, wanted});
    const auto scene = read_as_spz(*bytes);
    const int bits = std::to_integer<int>((*bytes)[13]);
    EXPECT_LE(spz_compare(cloud, scene->cloud).position, std::ldexp(0.6, -bits)) << farthest;
    return bits;
  };
  EXPECT_EQ(bits_for(2047.9f, 12), 12);
  EXPECT_EQ(bits_for(-4000.0f, 12), 11);
  EXPECT_EQ(bits_for(1e6f, 12), 3);
  EXPECT_EQ(bits_for(-8388600.0f, 12), 0);
  EXPECT_EQ(bits_for(21.0f, 23), 18);
  SplatCloud cloud = spz_cloud(400, 0);
  for (glm::vec3& p : cloud.positions) p.x += 9e6F;
  expect_error(encode_spz(cloud, "x.spz"), {"x.spz: positions", "farther than 8388607"});
}

TEST(Spz, WrongOptionsAreExplained) {
  const SplatCloud cloud = spz_cloud(1, 1);
  expect_error(encode_spz(cloud, "x", {2}), {"x: version: is 2; expected 3 to 4"});
  expect_error(encode_spz(cloud, "x", {3, -1}), {"fractional_bits", "0 to 23"});
  expect_error(encode_spz(cloud, "x", {3, 24}), {"fractional_bits"});
  expect_error(encode_spz(cloud, "x", {3, 12, 0}), {"sh1_bits", "1 to 8"});
  expect_error(encode_spz(cloud, "x", {3, 12, 5, 9}), {"sh_rest_bits"});
}

TEST(Spz, WriterLeavesOutNonFiniteSplatsAndRefusesBrokenClouds) {
  SplatCloud cloud = spz_cloud(4, 2);
  cloud.sh_rest[9].y = std::numeric_limits<float>::quiet_NaN();
  FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x"));
  FLUXGS_UNWRAP(scene, read_as_spz(bytes));
  EXPECT_EQ(scene.cloud.size(), 3u);
  cloud.rotations.pop_back();
  expect_error(encode_spz(cloud, "x.spz"), {"x.spz", "arrays disagree"});
}

TEST(Spz, FoundByContent) {
  EXPECT_FALSE(is_spz(Bytes{}));
  EXPECT_FALSE(is_spz(bytes_of("NGS")));
  EXPECT_FALSE(is_spz(bytes_of("\x1f\x8b")));
  EXPECT_FALSE(is_spz(bytes_of("\x1f\x8b\x08\x00 and nothing sensible")));
  EXPECT_FALSE(is_spz(gzip(bytes_of("ply\nformat ascii 1.0\n"))));
  EXPECT_TRUE(is_spz(gzip(bytes_of("NGSP"))));
  EXPECT_TRUE(is_spz(bytes_of("NGSP")));
}

// The parities against the polynomials, and the quaternions against matrices.
TEST(Spz, FlippedAxesAreThoseOfTheFormulas) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int code = 0; code < 8; ++code) {
    const glm::vec3 s((code & 1) ? -1 : 1, (code & 2) ? -1 : 1, (code & 4) ? -1 : 1);
    const io::AxisFlip flip = io::make_axis_flip(s);
    const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    std::array<double, 15> here{}, there{};
    math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, here.data());
    math::sh_basis(3, math::Vec3<double>{d.x * s.x, d.y * s.y, d.z * s.z}, there.data());
    for (std::size_t k = 0; k < 15; ++k) {
      EXPECT_NEAR(here[k] * double{flip.sh[k]}, there[k], 1e-12) << code << ' ' << k;
    }
    const glm::dquat q =
        glm::normalize(glm::dquat(normal(random), normal(random), normal(random), normal(random)));
    const glm::dmat3 mirror(s.x, 0, 0, 0, s.y, 0, 0, 0, s.z);
    const glm::dmat3 expected = mirror * glm::mat3_cast(q) * mirror;
    const glm::dmat3 flipped =
        glm::mat3_cast(glm::dquat(q.w, q.x * double{flip.rotation.x}, q.y * double{flip.rotation.y},
                                  q.z * double{flip.rotation.z}));
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(expected[c] - flipped[c]), 1e-12) << code;
  }
}

// A file with extension records, in front of the table or behind the data.
Bytes with_extensions(int version, const Bytes& records) {
  if (version == 4) {
    return spz4(1, 0, {kFixed, kAlpha, kColour, kScale, smallest_three()}, records);
  }
  return gzip(
      joined({spz_header(3, 1, 0, 2), kFixed, kAlpha, kColour, kScale, smallest_three(), records}));
}

TEST(Spz, ExtensionsAreFollowedOrSkipped) {
  constexpr std::uint32_t kAxes = 0xADBE0003;
  for (const int version : {3, 4}) {
    SCOPED_TRACE(version);
    const auto position = [&](const Bytes& records) {
      const auto scene = read_as_spz(with_extensions(version, records));
      EXPECT_TRUE(scene) << scene.error().message();
      return scene ? scene->cloud.positions[0] : glm::vec3(0);
    };
    const Bytes unknown = spz_extension(0x12345678, raw({1, 2, 3}));
    EXPECT_EQ(position(unknown), glm::vec3(1, 2, -3));
    EXPECT_EQ(position(spz_extension(kAxes, raw({0, 0, 0, 0}))), glm::vec3(1, 2, -3));
    EXPECT_EQ(position(spz_extension(kAxes, raw({4, 0, 0, 0}))), glm::vec3(1, -2, 3));    // RUB
    EXPECT_EQ(position(spz_extension(kAxes, raw({6, 0, 0, 0}))), glm::vec3(1, 2, -3));    // RDF
    EXPECT_EQ(position(spz_extension(kAxes, raw({7, 0, 0, 0}))), glm::vec3(-1, -2, -3));  // LUF
    EXPECT_EQ(position(joined({unknown, spz_extension(kAxes, raw({1, 0, 0, 0}))})),
              glm::vec3(-1, 2, 3));  // LDB
    const auto expect_warning = [&](const Bytes& records, const char* text) {
      FLUXGS_UNWRAP(scene, read_as_spz(with_extensions(version, records)));
      EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, 2, -3));
      ASSERT_EQ(scene.warnings.size(), 1U);
      EXPECT_TRUE(scene.warnings[0].contains(text)) << scene.warnings[0];
    };
    expect_warning(spz_extension(kAxes, raw({17, 0, 0, 0})), "names no axes (4 bytes, code 17)");
    expect_warning(spz_extension(kAxes, raw({0, 0, 0, 0})), "names no axes (4 bytes, code 0)");
    expect_warning(spz_extension(kAxes, raw({4})), "names no axes (1 bytes");
    expect_warning(raw({1, 2, 3}), "damaged; the last 3 bytes");
    Bytes lies = unknown;
    lies[4] = std::byte{200};
    expect_warning(lies, "damaged; the last 11 bytes");
  }
}

// All axes that a record can name, by the meaning of their letters.
TEST(Spz, AllAxesOfTheRecordAreFollowed) {
  // The unit vectors of the file's axes, in right, down, front.
  const std::map<char, glm::vec3> letters{{'R', {1, 0, 0}},  {'L', {-1, 0, 0}}, {'D', {0, 1, 0}},
                                          {'U', {0, -1, 0}}, {'F', {0, 0, 1}},  {'B', {0, 0, -1}}};
  const std::array<const char*, 16> names{"LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
                                          "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};
  const glm::vec3 stored(1, 2, -3);
  for (std::size_t k = 0; k < names.size(); ++k) {
    SCOPED_TRACE(names[k]);
    const auto at = [&](std::size_t axis) { return letters.at(names[k][axis]); };
    FLUXGS_UNWRAP(scene, read_as_spz(with_extensions(
                             4, spz_extension(0xADBE0003, raw({int(k) + 1, 0, 0, 0})))));
    EXPECT_EQ(scene.cloud.positions[0], at(0) * stored.x + at(1) * stored.y + at(2) * stored.z);
    // A shape is a covariance, turned and mirrored with the axes.
    FLUXGS_UNWRAP(plain, read_as_spz(with_extensions(4, {})));
    const auto covariance = [](const SplatCloud& cloud) {
      const glm::mat3 r = glm::mat3_cast(glm::normalize(cloud.rotations[0]));
      const glm::vec3 s(1, 4, 9);
      return r * glm::mat3(s.x, 0, 0, 0, s.y, 0, 0, 0, s.z) * glm::transpose(r);
    };
    const glm::mat3 axes(at(0), at(1), at(2));
    const glm::mat3 expected = axes * covariance(plain.cloud) * glm::transpose(axes);
    const glm::mat3 found = covariance(scene.cloud);
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(expected[c] - found[c]), 1e-4);
  }
}

// The colours of a scene whose record says that z is up, seen along turned directions.
TEST(Spz, HarmonicsTurnWithTheAxes) {
  const SplatCloud cloud = spz_cloud(20, 3);
  SpzOptions options{.version = 4, .sh1_bits = 8, .sh_rest_bits = 8};
  FLUXGS_UNWRAP(file, encode_spz(cloud, "x", options));
  FLUXGS_UNWRAP(plain, read_as_spz(file));
  constexpr std::size_t kCode = 32 + 8;  // of the record behind the header
  ASSERT_EQ(file[kCode], std::byte{6});
  file[kCode] = std::byte{12};  // right, front, up
  FLUXGS_UNWRAP(turned, read_as_spz(file));
  const glm::dvec3 d = glm::normalize(glm::dvec3(0.3, -0.5, 0.7));  // in the file's axes
  std::array<double, 15> before{}, after{};
  math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, before.data());
  math::sh_basis(3, math::Vec3<double>{d.x, -d.z, d.y}, after.data());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    glm::dvec3 a(0), b(0);
    for (std::size_t k = 0; k < 15; ++k) {
      a += before[k] * glm::dvec3(plain.cloud.sh_rest[15 * i + k]);
      b += after[k] * glm::dvec3(turned.cloud.sh_rest[15 * i + k]);
    }
    EXPECT_LT(glm::length(a - b), 1e-5);
  }
}

TEST(Spz, DegreeFourIsLeftOut) {
  Bytes sh;
  for (int k = 0; k < 72; ++k) sh.push_back(static_cast<std::byte>(128 + k));
  FLUXGS_UNWRAP(scene,
                read_as_spz(spz4(1, 4, {kFixed, kAlpha, kColour, kScale, smallest_three(), sh})));
  EXPECT_EQ(scene.cloud.sh_degree, 3);
  EXPECT_EQ(scene.cloud.sh_rest[14], glm::vec3(42, 43, 44) / 128.0F);
  ASSERT_EQ(scene.warnings.size(), 1U);
  EXPECT_TRUE(scene.warnings[0].contains("beyond degree 3")) << scene.warnings[0];
}

TEST(Spz, TheFilterComesBack) {
  SplatCloud cloud = spz_cloud(5, 0);
  for (const int version : {3, 4}) {
    for (const bool compensated : {false, true}) {
      cloud.filter.compensated = compensated;
      FLUXGS_UNWRAP(bytes, write_spz(cloud, "x", {.spz_version = version}));
      FLUXGS_UNWRAP(scene, read_as_spz(bytes));
      EXPECT_EQ(scene.cloud.filter, cloud.filter);
      EXPECT_TRUE(scene.warnings.empty());
    }
  }
}

// A few far splats leave the others their precision, and look as before from within the scene.
TEST(Spz, FarSplatsArePulledIn) {
  SplatCloud cloud = spz_cloud(5000, 0);
  cloud.positions[7] = {1e5F, 2e4F, -3e4F};
  cloud.log_scales[7] = glm::vec3(2);
  cloud.positions[8] = {0, -7e9F, 0};
  std::vector<std::string> warnings;
  SpzOptions options{.version = 4};
  options.warn = [&](const std::string& text) { warnings.push_back(text); };
  FLUXGS_UNWRAP(bytes, encode_spz(cloud, "x", options));
  EXPECT_EQ(bytes[13], std::byte{12});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(warnings[0].starts_with("2 of 5000 splats are farther than 2048")) << warnings[0];
  FLUXGS_UNWRAP(scene, read_as_spz(bytes));
  const glm::vec3 before = cloud.positions[7], after = scene.cloud.positions[7];
  const float factor = glm::length(after) / glm::length(before);
  EXPECT_LT(factor, 0.03F);
  EXPECT_NEAR(glm::dot(glm::normalize(before), glm::normalize(after)), 1, 1e-4);
  EXPECT_NEAR(scene.cloud.log_scales[7].x, 2 + std::log(factor), 1.0 / 32 + 1e-3);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (i != 7 && i != 8) {
      ASSERT_LT(glm::distance(scene.cloud.positions[i], cloud.positions[i]), 3e-4F) << i;
    }
  // A scene of which much lies far keeps it where it is, with coarser steps.
  for (std::size_t i = 0; i < 2500; ++i) cloud.positions[i] *= 200;
  warnings.clear();
  FLUXGS_UNWRAP(wide, encode_spz(cloud, "x", options));
  EXPECT_LT(wide[13], std::byte{12});
}

TEST(Spz, NonFiniteHalvesAreDroppedAndCounted) {
  const Bytes nan = raw({0x00, 0x7e, 0x00, 0x40, 0x00, 0xc2});
  const Bytes infinite = raw({0x00, 0x3c, 0x00, 0xfc, 0x00, 0xc2});
  const auto three = [](const Bytes& b) { return joined({b, b, b}); };
  FLUXGS_UNWRAP(scene,
                read_as_spz(gzip(joined({spz_header(1, 3, 0), nan, kHalves, infinite, three(kAlpha),
                                         three(kColour), three(kScale), three(kThree)}))));
  EXPECT_EQ(scene.dropped, 2u);
  ASSERT_EQ(scene.cloud.size(), 1u);
  EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, 2, -3));
}

// The same scene in three formats of an independent writer, and in ours: the axes are right.
TEST(Spz, AgreesWithAnIndependentWriter) {
  const auto ply = data_file("splats/plush-dog/point_cloud_29999_clean.ply");
  const auto glb = data_file("splats/plush-dog/converted/plush-dog.glb");
  if (!ply || !glb) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
  FLUXGS_UNWRAP(original, read_ply(*read_file(*ply), "ply"));
  FLUXGS_UNWRAP(gltf, read_glb(*read_file(*glb), "glb"));
  SplatCloud limited = original.cloud;  // to what SPZ can hold
  const auto limit = [](glm::vec3& v, float least, float most) {
    for (int c = 0; c < 3; ++c) v[c] = std::clamp(v[c], least, most);
  };
  for (glm::vec3& s : limited.log_scales) limit(s, -10, 5.9375f);
  for (glm::vec3& c : limited.sh_dc) limit(c, -0.5f / 0.15f, 0.5f / 0.15f);
  for (glm::vec3& c : limited.sh_rest) limit(c, -1, 1);
  for (const char* version : {"v3", "v4"}) {
    const auto path =
        data_file(fmt::format("splats/plush-dog/converted/plush-dog.{}.spz", version));
    ASSERT_TRUE(path);
    FLUXGS_UNWRAP(scene, read_spz(*read_file(*path), "spz"));
    // Their SH coefficients are rounded to 8 bits first and then to fewer.
    SpzWorst allowed = spz_allowed();
    allowed.sh1 += 1.0 / 256;
    allowed.sh_rest += 1.0 / 256;
    expect_within(fmt::format("plush-dog .ply against splat-transform's {}.spz", version).c_str(),
                  spz_compare(limited, scene.cloud), allowed);
    EXPECT_LT(spz_compare(gltf.cloud, scene.cloud).position, 1.3e-4);
    FLUXGS_UNWRAP(own_bytes, encode_spz(original.cloud, "x", {version[1] - '0'}));
    FLUXGS_UNWRAP(own, read_as_spz(own_bytes));
    expect_within("plush-dog .ply against our file", spz_compare(limited, own.cloud),
                  spz_allowed());
    expect_within("our file against theirs, twice the steps", spz_compare(own.cloud, scene.cloud),
                  spz_allowed(11, 4, 3));
    std::printf("%s: %zu bytes, theirs %zu\n", version, own_bytes.size(), scene.bytes);
  }
}

// By its compressed .ply this scene stands on y = 0 and reaches up to y = -3.18; the .spz was
// written with the axes of the specification.
TEST(Spz, ReadsARealSceneOfVersion4) {
  const auto path = data_file("splats/biker/biker.spz");
  if (!path) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
  FLUXGS_UNWRAP(scene, read_spz(*read_file(*path), "biker.spz", SpzAxes::right_up_back));
  EXPECT_EQ(scene.cloud.size(), 152746u);
  EXPECT_EQ(scene.cloud.sh_degree, 0);
  EXPECT_EQ(scene.dropped, 0u);
  glm::vec3 least(1e9f), most(-1e9f);
  for (const glm::vec3& p : scene.cloud.positions) {
    least = glm::min(least, p);
    most = glm::max(most, p);
  }
  EXPECT_LT(glm::length(least - glm::vec3(-0.621256, -3.180076, -0.532257)), 4e-4);
  EXPECT_LT(glm::length(most - glm::vec3(0.414404, 0, 0.613281)), 4e-4);
}

}  // namespace
}  // namespace fluxgs
