#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "compressed_ply_support.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/io/scene.h"

namespace fluxgs {
namespace {

using namespace test;

double sigmoid(double logit) { return 1 / (1 + std::exp(-logit)); }

// A file of one splat whose packed words the caller fills in.
CompressedPly one_splat_file(const PackedSplat& splat) {
  CompressedPly file;
  file.chunks = {{0, 10, -1, 1, 20, 3, -5, -4, -3, -1, -2, -3, 0, 0.25f, -1, 1, 0.75f, 2}};
  file.splats = {splat};
  return file;
}

TEST(CompressedPly, KnownValues) {
  // position (1, 0, 1023/2047), rotation w largest, scale (0, 1/3, 1), colour (0, 1, 1/5)
  PackedSplat packed;
  packed.position = 2047u << 21 | 0u << 11 | 1023u;
  packed.rotation = 0u << 30 | 1023u << 20 | 0u << 10 | 0u;
  packed.scale = 0u << 21 | 341u << 11 | 2047u;
  packed.colour = 0u << 24 | 255u << 16 | 51u << 8 | 102u;
  FLUXGS_UNWRAP(scene, read(one_splat_file(packed)));
  const SplatCloud& cloud = scene.cloud;
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.positions[0], glm::vec3(1, 10, static_cast<float>(-1 + 4 * 1023.0 / 2047)));
  EXPECT_EQ(cloud.log_scales[0], glm::vec3(-5, static_cast<float>(-4 + 2 / 3.0), -3));
  EXPECT_FLOAT_EQ(cloud.sh_dc[0].x, static_cast<float>(-0.5 / math::kSh0));
  EXPECT_FLOAT_EQ(cloud.sh_dc[0].y, static_cast<float>(0.25 / math::kSh0));
  EXPECT_FLOAT_EQ(cloud.sh_dc[0].z, static_cast<float>((-1 + 3 * 0.2 - 0.5) / math::kSh0));
  EXPECT_FLOAT_EQ(cloud.opacity_logits[0], std::log(0.4f / 0.6f));
  const float half = std::sqrt(0.5f);  // more than a unit: the largest becomes 0
  EXPECT_EQ(cloud.rotations[0], glm::quat(0, half, -half, -half));
  EXPECT_EQ(scene.format, "compressed.ply");
  EXPECT_EQ(scene.attribute_bits.at("chunks"), 18 * 32);
  EXPECT_EQ(scene.attribute_bits.at("position"), 32);
}

// Each of the four components as the largest one; the others keep the order w, x, y, z.
TEST(CompressedPly, TheLargestComponentIsLeftOut) {
  const double a = 0.1, b = -0.2, c = 0.3, m = std::sqrt(1 - a * a - b * b - c * c);
  const auto level = [](double v) { return pack_fraction(v, -std::sqrt(0.5), std::sqrt(0.5), 10); };
  const std::array<std::array<double, 4>, 4> expected{
      {{m, a, b, c}, {a, m, b, c}, {a, b, m, c}, {a, b, c, m}}};
  for (std::uint32_t which = 0; which < 4; ++which) {
    FLUXGS_UNWRAP(scene, read(one_splat_file({.rotation = which << 30 | level(a) << 20 |
                                                          level(b) << 10 | level(c)})));
    const glm::quat& q = scene.cloud.rotations[0];
    const std::array<float, 4> parts{q.w, q.x, q.y, q.z};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(parts[i], expected[which][i], 0.0015) << which;
    EXPECT_NEAR(glm::length(q), 1, 1e-6);
  }
}

TEST(CompressedPly, OlderFilesHaveNoColourBounds) {
  CompressedPly file = one_splat_file({.colour = 255u << 24 | 0u << 16 | 51u << 8 | 255u});
  file.colour_bounds = false;
  FLUXGS_UNWRAP(scene, read(file));
  EXPECT_FLOAT_EQ(scene.cloud.sh_dc[0].x, static_cast<float>(0.5 / math::kSh0));
  EXPECT_FLOAT_EQ(scene.cloud.sh_dc[0].y, static_cast<float>(-0.5 / math::kSh0));
  EXPECT_FLOAT_EQ(scene.cloud.sh_dc[0].z, static_cast<float>(-0.3 / math::kSh0));
  EXPECT_EQ(scene.attribute_bits.at("chunks"), 12 * 32);
}

TEST(CompressedPly, OpacitiesAtTheEndsStayFinite) {
  CompressedPly file = one_splat_file({.colour = 0});
  file.splats.push_back({.colour = 255});
  FLUXGS_UNWRAP(scene, read(file));
  ASSERT_EQ(scene.cloud.size(), 2u);
  EXPECT_NEAR(scene.cloud.opacity_logits[0], -87.3f, 0.1f);
  EXPECT_NEAR(scene.cloud.opacity_logits[1], 17.3f, 0.1f);
}

TEST(CompressedPly, ShAreChannelMajorBytes) {
  CompressedPly file = one_splat_file({});
  file.sh_degree = 1;
  file.sh = {0, 1, 127, 128, 254, 255, 64, 192, 2};  // red, green, blue of three coefficients each
  FLUXGS_UNWRAP(scene, read(file));
  EXPECT_EQ(scene.cloud.sh_degree, 1);
  const std::vector<glm::vec3> expected{{-4, 1 / 64.0f, 64.5f / 32 - 4},
                                        {1.5f / 32 - 4, 254.5f / 32 - 4, 192.5f / 32 - 4},
                                        {-1 / 64.0f, 4, 2.5f / 32 - 4}};
  EXPECT_EQ(scene.cloud.sh_rest, expected);
  EXPECT_EQ(scene.attribute_bits.at("sh_rest"), 72);
}

// The worst error of each attribute stays within half a step of its chunk.
TEST(CompressedPly, RoundTripIsAsExactAsTheFormat) {
  for (const int degree : {0, 1, 2, 3}) {
    for (const std::size_t count : {0, 1, 256, 257, 2000}) {
      const SplatCloud cloud = random_cloud(count, degree, 5, 20.0f);
      const CompressedPly file = compress(cloud);
      FLUXGS_UNWRAP(scene, read(file));
      const SplatCloud& back = scene.cloud;
      EXPECT_EQ(back.sh_degree, degree);
      EXPECT_EQ(scene.dropped, 0u);
      ASSERT_EQ(back.size(), count);
      double worst[3] = {0, 0, 0}, cosine = 1, opacity = 0;  // in steps, but for the cosine
      const auto check = [](double a, double b, double step, double& most) {
        const double error = std::abs(a - b);
        ASSERT_LE(error, 0.5 * step + 2e-6);
        most = std::max(most, step > 1e-4 ? error / step : 0);
      };
      for (std::size_t i = 0; i < count; ++i) {
        const auto& bounds = file.chunks[i / 256];
        for (int c = 0; c < 3; ++c) {
          const auto k = static_cast<std::size_t>(c);
          const double levels = c == 1 ? 1023 : 2047;
          const auto step = [&](std::size_t at, double steps) {
            return (double{bounds[at + 3 + k]} - bounds[at + k]) / steps;
          };
          check(back.positions[i][c], cloud.positions[i][c], step(0, levels), worst[0]);
          check(back.log_scales[i][c], cloud.log_scales[i][c], step(6, levels), worst[1]);
          check(display_colour(back.sh_dc[i][c]), display_colour(cloud.sh_dc[i][c]), step(12, 255),
                worst[2]);
        }
        check(sigmoid(back.opacity_logits[i]), sigmoid(cloud.opacity_logits[i]), 1 / 255.0,
              opacity);
        // half a step, √2/1023/2, in three components, and what follows in the largest
        const glm::dquat original = glm::normalize(glm::dquat(cloud.rotations[i]));
        cosine = std::min(cosine, std::abs(glm::dot(glm::dquat(back.rotations[i]), original)));
      }
      ASSERT_GT(cosine, 1 - 5e-6);
      for (std::size_t k = 0; k < cloud.sh_rest.size(); ++k) {
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(back.sh_rest[k][c], cloud.sh_rest[k][c], 1 / 64.0);
      }
      if (count < 2000) continue;
      std::printf(
          "compressed.ply round trip, in steps: position %.3f, log-scale %.3f, colour %.3f, "
          "opacity %.3f; 1 - cosine of the rotation %.1e\n",
          worst[0], worst[1], worst[2], opacity, 1 - cosine);
    }
  }
}

TEST(CompressedPly, IsFoundByItsContent) {
  const Bytes packed = compress(random_cloud(300, 1)).bytes();
  EXPECT_TRUE(is_compressed_ply(packed));
  FLUXGS_UNWRAP(scene, read_scene(packed, "renamed.bin"));
  EXPECT_EQ(scene.format, "compressed.ply");
  EXPECT_EQ(scene.bytes, packed.size());
  EXPECT_EQ(scene.cloud.size(), 300u);
  FLUXGS_UNWRAP(plain, encode_ply(random_cloud(3, 1), "x"));
  EXPECT_FALSE(is_compressed_ply(plain));
  EXPECT_FALSE(is_compressed_ply({}));
  EXPECT_FALSE(is_compressed_ply(bytes_of("ply\npacked_position")));
  expect_error(read_ply(packed, "x.ply"), {"property x is missing", "3DGS .ply"});
}

// Properties are found by name among others, elements in any order.
TEST(CompressedPly, FindsPropertiesByNameWhateverSurroundsThem) {
  const SplatCloud cloud = random_cloud(2, 1);
  const CompressedPly file = compress(cloud);
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment x\nelement sh 2\n";
  for (int i = 8; i >= 0; --i) text += fmt::format("property uint8 f_rest_{}\n", i);
  text += "element other 1\nproperty double a\nelement vertex 2\nproperty uchar extra\n";
  for (const char* name : {"packed_color", "packed_scale", "packed_rotation", "packed_position"}) {
    text += fmt::format("property uint32 {}\n", name);
  }
  text += "element chunk 1\nproperty short extra\n";
  for (std::size_t i = 18; i-- > 0;) {
    text += fmt::format("property float32 {}\n", kChunkProperties[i]);
  }
  Bytes bytes = bytes_of(text + "end_header\n");
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t k = 9; k-- > 0;) append(bytes, file.sh[9 * i + k]);
  }
  append(bytes, 1.0);
  for (const PackedSplat& s : file.splats) {
    append(bytes, std::uint8_t(7));
    for (const std::uint32_t word : {s.colour, s.scale, s.rotation, s.position})
      append(bytes, word);
  }
  append(bytes, std::int16_t(7));
  for (std::size_t i = 18; i-- > 0;) append(bytes, file.chunks[0][i]);
  FLUXGS_UNWRAP(shuffled, read_scene(bytes, "x.ply"));
  FLUXGS_UNWRAP(plain, read(file));
  EXPECT_EQ(shuffled.cloud.positions, plain.cloud.positions);
  EXPECT_EQ(shuffled.cloud.log_scales, plain.cloud.log_scales);
  EXPECT_EQ(shuffled.cloud.rotations, plain.cloud.rotations);
  EXPECT_EQ(shuffled.cloud.opacity_logits, plain.cloud.opacity_logits);
  EXPECT_EQ(shuffled.cloud.sh_dc, plain.cloud.sh_dc);
  EXPECT_EQ(shuffled.cloud.sh_rest, plain.cloud.sh_rest);
}

TEST(CompressedPly, CutAtAnyByteIsAnError) {
  const Bytes bytes = compress(random_cloud(3, 1)).bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));  // exactly sized for ASan
    EXPECT_FALSE(read_compressed_ply(cut, "x.ply")) << size;
    const auto scene = read_scene(cut, "x.ply");
    ASSERT_FALSE(scene) << size;
    EXPECT_EQ(scene.error().file, "x.ply");
  }
  expect_error(read_scene(Bytes(bytes.begin(), bytes.end() - 1), "x.ply"),
               {"x.ply: header", "promises", "bytes of data"});
}

// The header of a good file with one piece replaced, before its data.
Expected<SceneFile> read_edited(const CompressedPly& file, const std::string& from,
                                const std::string& to) {
  std::string text = file.header();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  Bytes bytes = bytes_of(text);
  const Bytes data = file.data();
  bytes.insert(bytes.end(), data.begin(), data.end());
  bytes.resize(bytes.size() + 4096);  // enough for what the edit may promise
  return read_compressed_ply(bytes, "test.ply");
}

TEST(CompressedPly, CountsThatDisagreeAreRefused) {
  const CompressedPly file = compress(random_cloud(300, 1));
  expect_error(read_edited(file, "chunk 2", "chunk 1"),
               {"test.ply: element chunk", "has 1 rows; expected 2", "256 of the 300"});
  expect_error(read_edited(file, "chunk 2", "chunk 3"), {"has 3 rows; expected 2"});
  expect_error(read_edited(file, "chunk 2", "chunk 0"), {"has 0 rows; expected 2"});
  expect_error(read_edited(file, "vertex 300", "vertex 256"), {"has 2 rows; expected 1"});
  expect_error(read_edited(file, "vertex 300", "vertex 0"), {"has 2 rows; expected 0"});
  expect_error(read_edited(file, "sh 300", "sh 299"),
               {"test.ply: element sh", "has 299 rows; expected 300"});
  for (const char* count : {"4294967296", "1152921504606846976", "18446744073709551615"}) {
    for (const char* element : {"chunk 2", "vertex 300", "sh 300"}) {
      const std::string name(element, std::strchr(element, ' ') + 1);
      expect_error(read_edited(file, element, name + count), {"header", "promises"});
    }
  }
  // Without properties, no count promises bytes: none may be believed.
  expect_error(
      read_compressed_ply(bytes_of("ply\nformat binary_little_endian 1.0\nelement chunk 1\n"
                                   "element vertex 18446744073709551615\nend_header\n"),
                          "x"),
      {"element vertex", "packed_position is missing"});
}

TEST(CompressedPly, MissingAndMistypedPropertiesAreNamed) {
  const CompressedPly file = compress(random_cloud(3, 1));
  for (const char* property : kChunkProperties) {
    const std::string line = fmt::format("property float {}\n", property);
    expect_error(read_edited(file, line, ""),
                 {"element chunk", fmt::format("property {} is missing", property)});
    expect_error(read_edited(file, line, fmt::format("property double {}\n", property)),
                 {"element chunk", property, "expected float"});
    expect_error(read_edited(file, line, line + line), {property, "appears twice"});
  }
  for (const char* property : kPackedProperties) {
    const std::string line = fmt::format("property uint {}\n", property);
    expect_error(read_edited(file, line, ""),
                 {"element vertex", fmt::format("property {} is missing", property)});
    expect_error(read_edited(file, line, fmt::format("property int {}\n", property)),
                 {"element vertex", property, "expected uint"});
  }
  expect_error(read_edited(file, "property uchar f_rest_8\n", ""),
               {"element sh", "has 8 properties f_rest_*"});
  expect_error(read_edited(file, "f_rest_8\n", "f_rest_9\n"),
               {"element sh", "f_rest_8 is missing"});
  expect_error(read_edited(file, "uchar f_rest_3\n", "char f_rest_3\n"),
               {"element sh", "f_rest_3", "expected uchar"});
  expect_error(read_edited(file, "element chunk", "element junk"), {"no element \"chunk\""});
  expect_error(read_edited(file, "element vertex", "element vortex"), {"no element \"vertex\""});
  expect_error(read_edited(file, "binary_little_endian", "binary_big_endian"),
               {"header", "binary_little_endian"});
  expect_error(read_edited(file, "element chunk",
                           "element a 0\nproperty list uchar int b\n"
                           "element chunk"),
               {"element a", "list"});
}

TEST(CompressedPly, BoundsThatAreNotFiniteAreRefused) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    for (std::size_t i = 0; i < 18; ++i) {
      CompressedPly file = compress(random_cloud(300, 0));
      file.chunks[1][i] = bad;
      expect_error(read(file), {"element chunk, row 1", kChunkProperties[i], "finite"});
    }
  }
}

// Bounds of any finite size, also in the wrong order, give finite splats or dropped ones.
TEST(CompressedPly, ExtremeBoundsAreHarmless) {
  constexpr float kMax = std::numeric_limits<float>::max();
  CompressedPly file = compress(random_cloud(256, 0));
  file.chunks[0].fill(-kMax);
  for (const std::size_t at : {3, 4, 5, 9, 10, 11}) file.chunks[0][at] = kMax;
  for (const std::size_t at : {12, 13, 14, 15, 16, 17}) file.chunks[0][at] = 0.5f;
  FLUXGS_UNWRAP(wide, read(file));
  EXPECT_EQ(wide.cloud.size(), 256u);
  file.chunks[0][12] = kMax;  // a coefficient 3.5 times as large: beyond float
  FLUXGS_UNWRAP(coloured, read(file));
  EXPECT_GT(coloured.dropped, 0u);
  EXPECT_EQ(coloured.cloud.size() + coloured.dropped, 256u);
  EXPECT_EQ(count_non_finite(coloured.cloud), 0u);
}

TEST(CompressedPly, DamagedFilesNeverCrash) {
  const Bytes bytes = compress(random_cloud(2, 1)).bytes();
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    Bytes damaged = bytes;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = std::byte(random());
    if (random() % 4 == 0) damaged.resize(random() % damaged.size());
    is_compressed_ply(damaged);
    const auto scene = read_compressed_ply(damaged, "x");
    if (scene) {
      EXPECT_EQ(count_non_finite(scene->cloud), 0u);
    }
  }
}

TEST(CompressedPly, ReadsRealFiles) {
  const std::map<std::string, std::size_t> files{{"splats/biker/biker.compressed.ply", 152746},
                                                 {"splats/guitar/guitar.compressed.ply", 90854}};
  for (const auto& [file, count] : files) {
    const auto path = data_file(file);
    if (!path) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
    FLUXGS_UNWRAP(scene, read_scene(*path));
    EXPECT_EQ(scene.format, "compressed.ply");
    EXPECT_EQ(scene.cloud.size(), count);
    EXPECT_EQ(scene.cloud.sh_degree, 0);
    EXPECT_EQ(scene.dropped, 0u);
  }
}

// What one splat of a real file may differ by from the splat that it was made from.
struct Steps {
  glm::dvec3 position, log_scale, colour;
};

Steps steps_of(const float* bounds) {
  const auto steps = [&](int at, glm::dvec3 levels) {
    const glm::dvec3 low(bounds[at], bounds[at + 1], bounds[at + 2]);
    return (glm::dvec3(bounds[at + 3], bounds[at + 4], bounds[at + 5]) - low) / levels;
  };
  return {steps(0, {2047, 1023, 2047}), steps(6, {2047, 1023, 2047}), steps(12, glm::dvec3(255))};
}

bool within(const glm::vec3& a, const glm::vec3& b, const glm::dvec3& step) {
  for (int c = 0; c < 3; ++c) {
    // Half a step, and the rounding of floats on both sides.
    if (std::abs(double{a[c]} - b[c]) > 0.5 * step[c] + 2e-6) return false;
  }
  return true;
}

bool same_splat(const SplatCloud& a, std::size_t i, const SplatCloud& b, std::size_t j,
                const Steps& steps) {
  if (!within(a.positions[i], b.positions[j], steps.position)) return false;
  if (!within(a.log_scales[i], b.log_scales[j], steps.log_scale)) return false;
  if (!within(a.sh_dc[i], b.sh_dc[j], steps.colour / math::kSh0)) return false;
  if (std::abs(sigmoid(a.opacity_logits[i]) - sigmoid(b.opacity_logits[j])) > 0.5 / 255 + 1e-6) {
    return false;
  }
  const glm::dquat p(a.rotations[i]), q = glm::normalize(glm::dquat(b.rotations[j]));
  if (std::abs(glm::dot(p, q)) < 1 - 5e-6) return false;
  const auto rest = static_cast<std::size_t>(sh_rest_count(a.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) {
    const glm::vec3 limited = glm::clamp(b.sh_rest[j * rest + k], -4.0f, 4.0f);
    if (!within(a.sh_rest[i * rest + k], limited, glm::dvec3(1 / 32.0))) return false;
  }
  return true;
}

// Made by SuperSplat from the .ply beside it, in another order.
TEST(CompressedPly, RealFileAgreesWithItsSource) {
  const auto path = data_file("splats/plush-dog/point_cloud_29999_clean.compressed.ply");
  const auto source_path = data_file("splats/plush-dog/point_cloud_29999_clean.ply");
  if (!path || !source_path) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
  FLUXGS_UNWRAP(scene, read_scene(*path));
  FLUXGS_UNWRAP(source, read_scene(*source_path));
  const SplatCloud& cloud = scene.cloud;
  ASSERT_EQ(cloud.size(), source.cloud.size());
  EXPECT_EQ(cloud.sh_degree, 3);
  EXPECT_EQ(scene.dropped, 0u);

  FLUXGS_UNWRAP(bytes, read_file(*path));
  const std::size_t data = text_of(bytes).find("end_header\n") + 11;
  std::vector<std::size_t> by_x(source.cloud.size());
  for (std::size_t i = 0; i < by_x.size(); ++i) by_x[i] = i;
  const auto x = [&](std::size_t i) { return double{source.cloud.positions[i].x}; };
  std::ranges::sort(by_x, {}, x);
  std::vector<int> used(by_x.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    float bounds[18];
    std::memcpy(bounds, bytes.data() + data + i / 256 * sizeof bounds, sizeof bounds);
    const Steps steps = steps_of(bounds);
    const double reach = steps.position.x + 1e-5, at = cloud.positions[i].x;
    std::size_t found = 0;
    for (auto j = std::ranges::lower_bound(by_x, at - reach, {}, x);
         j != by_x.end() && x(*j) < at + reach; ++j) {
      if (!same_splat(cloud, i, source.cloud, *j, steps)) continue;
      ++found;
      ++used[*j];
    }
    ASSERT_EQ(found, 1u) << "splat " << i;
  }
  EXPECT_TRUE(std::ranges::all_of(used, [](int n) { return n == 1; }));
}

}  // namespace
}  // namespace fluxgs
