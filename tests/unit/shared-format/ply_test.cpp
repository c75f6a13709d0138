#include "fluxgs/io/ply.h"

#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include <fmt/format.h>

#include "fluxgs/io/file.h"
#include "support.h"

namespace fluxgs {
namespace {

using namespace test;

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_identical(const SplatCloud& a, const SplatCloud& b) {
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  EXPECT_TRUE(same_bits(a.log_scales, b.log_scales));
  EXPECT_TRUE(same_bits(a.rotations, b.rotations));
  EXPECT_TRUE(same_bits(a.opacity_logits, b.opacity_logits));
  EXPECT_TRUE(same_bits(a.sh_dc, b.sh_dc));
  EXPECT_TRUE(same_bits(a.sh_rest, b.sh_rest));
}

const std::vector<std::string> kProperties{"x",      "y",       "z",       "f_dc_0",  "f_dc_1",
                                           "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                           "rot_0",  "rot_1",   "rot_2",   "rot_3"};

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}
std::string vertex(std::uint64_t count, const std::vector<std::string>& properties,
                   const std::string& type = "float") {
  std::string text = fmt::format("element vertex {}\n", count);
  for (const auto& p : properties) text += fmt::format("property {} {}\n", type, p);
  return text;
}

Expected<SceneFile> read(const std::string& text) { return read_ply(bytes_of(text), "test.ply"); }

TEST(Ply, RoundTripIsBitExact) {
  for (const int degree : {0, 1, 2, 3}) {
    for (const std::size_t count : {0, 1, 100}) {
      SplatCloud cloud = random_cloud(count, degree, 7);
      if (count > 1) {  // values that a conversion would change
        cloud.positions[0] = {-0.0f, std::numeric_limits<float>::denorm_min(), 1e38f};
        cloud.rotations[0] = glm::quat(0, 0, 0, 0);
        cloud.opacity_logits[0] = -150;
        cloud.log_scales[0] = {15, -15, -1e30f};
      }
      FLUXGS_UNWRAP(bytes, encode_ply(cloud, "x.ply"));
      FLUXGS_UNWRAP(scene, read_ply(bytes, "x.ply"));
      expect_identical(cloud, scene.cloud);
      EXPECT_EQ(scene.dropped, 0u);
      EXPECT_EQ(scene.bytes, bytes.size());
    }
  }
}

TEST(Ply, RealFileComesBackByteForByte) {
  const auto path = data_file("splats/plush-dog/point_cloud_29999_clean.ply");
  if (!path) GTEST_SKIP() << "set FLUXGS_DATA to run on real scenes";
  FLUXGS_UNWRAP(original, read_file(*path));
  FLUXGS_UNWRAP(scene, read_ply(original, path->string()));
  EXPECT_EQ(scene.cloud.size(), 15105u);
  EXPECT_EQ(scene.cloud.sh_degree, 3);
  FLUXGS_UNWRAP(written, encode_ply(scene.cloud, "copy.ply"));
  EXPECT_TRUE(written == original);
}

TEST(Ply, RestIsChannelMajor) {
  SplatCloud cloud = random_cloud(1, 1);
  cloud.sh_rest = {{1, 10, 100}, {2, 20, 200}, {3, 30, 300}};
  FLUXGS_UNWRAP(bytes, encode_ply(cloud, "x.ply"));
  float rest[9];  // after x y z, normals and f_dc
  std::memcpy(rest, bytes.data() + bytes.size() - 26 * 4 + 9 * 4, sizeof rest);
  EXPECT_EQ(rest[0], 1);
  EXPECT_EQ(rest[1], 2);
  EXPECT_EQ(rest[2], 3);
  EXPECT_EQ(rest[3], 10);
  EXPECT_EQ(rest[8], 300);
}

// Every type, any order, extra properties and elements around the vertices, both byte orders.
TEST(Ply, FindsPropertiesByNameWhateverSurroundsThem) {
  const std::string elements =
      "comment made by hand\nelement camera 2\nproperty list uchar short pose\nproperty int id\n"
      "element vertex 2\n"
      "property double rot_3\nproperty uchar extra\nproperty char x\nproperty short y\n"
      "property int z\nproperty ushort f_dc_0\nproperty uint f_dc_1\nproperty uint8 f_dc_2\n"
      "property float64 opacity\nproperty float32 scale_0\nproperty int16 scale_1\n"
      "property int8 scale_2\nproperty int32 rot_0\nproperty uint16 rot_1\nproperty uint32 rot_2\n"
      "obj_info nothing\nelement face 1\nproperty list uchar int vertex_indices\n";
  for (const bool big : {false, true}) {
    Bytes data = bytes_of(header(big ? "binary_big_endian" : "binary_little_endian", elements));
    const auto put = [&](auto value) {
      auto raw = std::bit_cast<std::array<std::byte, sizeof value>>(value);
      if (big) std::ranges::reverse(raw);
      data.insert(data.end(), raw.begin(), raw.end());
    };
    for (int camera = 0; camera < 2; ++camera) {
      put(std::uint8_t(camera + 1));
      for (int i = 0; i <= camera; ++i) put(std::int16_t(-1));
      put(std::int32_t(9));
    }
    for (int i = 0; i < 2; ++i) {
      put(double(0.25 + i));
      put(std::uint8_t(99));
      put(std::int8_t(-3 + i));
      put(std::int16_t(-300 + i));
      put(std::int32_t(-70000 + i));
      put(std::uint16_t(60000 + i));
      put(std::uint32_t(4000000000u));
      put(std::uint8_t(200 + i));
      put(double(-2.5));
      put(0.125f);
      put(std::int16_t(-8));
      put(std::int8_t(-9));
      put(std::int32_t(1));
      put(std::uint16_t(2));
      put(std::uint32_t(3));
    }
    put(std::uint8_t(1));
    put(std::int32_t(0));
    FLUXGS_UNWRAP(scene, read_ply(data, "x.ply"));
    ASSERT_EQ(scene.cloud.size(), 2u);
    EXPECT_EQ(scene.cloud.positions[0], glm::vec3(-3, -300, -70000));
    EXPECT_EQ(scene.cloud.positions[1], glm::vec3(-2, -299, -69999));
    EXPECT_EQ(scene.cloud.sh_dc[1], glm::vec3(60001, 4e9f, 201));
    EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(0.125f, -8, -9));
    EXPECT_EQ(scene.cloud.opacity_logits[0], -2.5f);
    EXPECT_EQ(scene.cloud.rotations[1], glm::quat(1, 2, 3, 1.25f));
    // Cut anywhere, it is an error.
    for (std::size_t size = 0; size < data.size(); ++size) {
      EXPECT_FALSE(read_ply(Bytes(data.begin(), data.begin() + std::ptrdiff_t(size)), "x.ply"));
    }
  }
}

TEST(Ply, ReadsText) {
  const std::string elements =
      "element camera 1\nproperty list uchar float pose\n" + vertex(2, kProperties);
  const std::string row = "1 -2.5 3e-1 0 0 0 0.1 -1 -2 -3 1 0 0 0";
  FLUXGS_UNWRAP(scene, read(header("ascii", elements) + "2 5 6\n" + row + "\r\n" + row));
  ASSERT_EQ(scene.cloud.size(), 2u);
  EXPECT_EQ(scene.cloud.positions[1], glm::vec3(1, -2.5f, 0.3f));
  EXPECT_EQ(scene.cloud.opacity_logits[0], 0.1f);
  expect_error(read(header("ascii", elements) + "2 5 6\n" + row + "\n" + row.substr(0, 30) +
                    " word and some more text"),
               {"row 1", "expected a number"});
  expect_error(read(header("ascii", elements) + "2000000000 5 6\n" + row + "\n" + row),
               {"camera", "past the end"});
}

// 2D Gaussian Splatting (Huang et al. 2024) stores two scales; others store the logarithm of 0.
TEST(Ply, FlatSplatsGetAThirdAxisOfNearlyNothing) {
  std::vector<std::string> flat = kProperties;
  std::erase(flat, "scale_2");
  const auto two = read(header("ascii", vertex(1, flat)) + "1 2 3 0 0 0 0 -1 -2 1 0 0 0\n");
  ASSERT_TRUE(two) << two.error().message();
  EXPECT_EQ(two->cloud.log_scales[0], glm::vec3(-1, -2, -20));
  EXPECT_EQ(two->cloud.rotations[0], glm::quat(1, 0, 0, 0));
  const auto zero =
      read(header("ascii", vertex(1, kProperties)) + "1 2 3 0 0 0 0 -1 -2 -inf 1 0 0 0\n");
  ASSERT_TRUE(zero) << zero.error().message();
  EXPECT_EQ(zero->dropped, 0u);
  EXPECT_EQ(zero->cloud.log_scales[0], glm::vec3(-1, -2, -20));
}

// nerfstudio's exporter writes colours of 8 bits on demand.
TEST(Ply, ColoursStandForTheConstantCoefficient) {
  const std::string elements =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property TYPE red\nproperty TYPE green\nproperty TYPE blue\nproperty float opacity\n"
      "property float scale_0\nproperty float scale_1\nproperty float scale_2\n"
      "property float rot_0\nproperty float rot_1\nproperty float rot_2\nproperty float rot_3\n";
  for (const auto& [type, values] : {std::pair<std::string, std::string>("uchar", "255 0 51"),
                                     {"ushort", "65535 0 13107"},
                                     {"float", "1 0 0.2"}}) {
    std::string typed = elements;
    for (std::size_t at; (at = typed.find("TYPE")) != std::string::npos;)
      typed.replace(at, 4, type);
    const auto scene = read(header("ascii", typed) + "1 2 3 " + values + " 0.5 -1 -2 -3 1 0 0 0\n");
    ASSERT_TRUE(scene) << scene.error().message();
    const glm::vec3 colour = 0.28209479f * scene->cloud.sh_dc[0] + 0.5f;
    EXPECT_NEAR(colour.r, 1, 1e-6) << type;
    EXPECT_NEAR(colour.g, 0, 1e-6);
    EXPECT_NEAR(colour.b, 0.2, 1e-6);
    EXPECT_EQ(scene->cloud.opacity_logits[0], 0.5f);
  }
}

TEST(Ply, AcceptsWindowsLineEndsInTheHeader) {
  std::string text = header("ascii", vertex(1, kProperties));
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) {
    text.replace(at, 1, "\r\n");
  }
  EXPECT_TRUE(read(text + "1 2 3 0 0 0 0 0 0 0 1 0 0 0"));
}

TEST(Ply, CutAtAnyByteIsAnError) {
  FLUXGS_UNWRAP(bytes, encode_ply(random_cloud(3, 1), "x.ply"));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));  // exactly sized for ASan
    EXPECT_FALSE(read_ply(cut, "x.ply")) << size;
  }
  bytes.pop_back();
  expect_error(read_ply(bytes, "x.ply"), {"x.ply: header", "promises 312 bytes", "holds 311"});
}

TEST(Ply, HugeCountsAreRefusedBeforeAllocating) {
  for (const char* count : {"2147483648", "4294967296", "9223372036854775808",
                            "18446744073709551615", "329406144173384851"}) {
    for (const char* format : {"binary_little_endian", "ascii"}) {
      std::string elements = vertex(1, kProperties);
      elements.replace(elements.find(" 1\n"), 2, std::string(" ") + count);
      expect_error(read(header(format, elements) + "1 2 3"), {"header", "promises", "holds 5"});
    }
  }
  expect_error(read(header("ascii", "element vertex 18446744073709551616\n")), {"line 3", "count"});
  expect_error(read(header("ascii", "element vertex -1\n")), {"line 3", "count"});
  // Two elements whose sizes add up to a small number modulo 2^64.
  expect_error(read(header("binary_little_endian",
                           "element a 9223372036854775808\nproperty char q\n"
                           "element b 9223372036854775808\nproperty char q\n" +
                               vertex(0, kProperties))),
               {"promises more than"});
  // Elements without properties take no room and no time, whatever their count.
  EXPECT_TRUE(
      read(header("ascii", "element void 18446744073709551615\n" + vertex(0, kProperties))));
  EXPECT_TRUE(read(header("binary_little_endian",
                          "element void 18446744073709551615\n" + vertex(0, kProperties))));
}

TEST(Ply, ListsBeforeTheVerticesCannotHideMissingBytes) {
  // One list that takes the bytes promised to the vertex.
  Bytes data =
      bytes_of(header("binary_little_endian", "element camera 1\nproperty list uint uchar pose\n" +
                                                  vertex(1, kProperties)));
  append(data, std::uint32_t(40));
  data.resize(data.size() + 56);
  expect_error(read_ply(data, "x"), {"element vertex", "needs 56 bytes", "holds 16"});
  data = bytes_of(header("binary_little_endian", "element camera 1\nproperty list uint double p\n" +
                                                     vertex(0, kProperties)));
  append(data, std::uint32_t(0xffffffff));
  expect_error(read_ply(data, "x"), {"camera", "past the end"});
}

TEST(Ply, MissingPropertiesAreNamed) {
  for (const std::string& missing : kProperties) {
    if (missing == "scale_2") continue;  // a flat splat
    std::vector<std::string> some;
    std::ranges::copy_if(kProperties, std::back_inserter(some),
                         [&](const auto& p) { return p != missing; });
    expect_error(read(header("binary_little_endian", vertex(0, some))),
                 {"element vertex", "property " + missing + " is missing"});
  }
}

TEST(Ply, MeshesAndPointCloudsAreCalledThat) {
  for (const std::vector<std::string>& properties :
       {std::vector<std::string>{"x", "y", "z"}, {"x", "y", "z", "red", "green", "blue"}})
    expect_error(read(header("binary_little_endian", vertex(0, properties))),
                 {"element vertex", "a mesh or a point cloud", "3DGS .ply"});
}

TEST(Ply, BytesBehindTheLastSplatAreWarnedOf) {
  const auto ply = encode_ply(random_cloud(3, 1), "x", {});
  ASSERT_TRUE(ply);
  auto longer = *ply;
  longer.resize(longer.size() + 7);
  EXPECT_TRUE(read_ply(*ply, "x")->warnings.empty());
  EXPECT_THAT(read_ply(longer, "x")->warnings,
              testing::ElementsAre(testing::HasSubstr("7 bytes behind the 3 splats")));
  std::string text = "1 2 3 4 5 6 7 8 9 10 1 0 0 0 \n \n";
  EXPECT_TRUE(read(header("ascii", vertex(1, kProperties)) + text)->warnings.empty());
  EXPECT_THAT(read(header("ascii", vertex(1, kProperties)) + text + "8 9\n")->warnings,
              testing::ElementsAre(testing::HasSubstr("4 bytes behind the 1 splats")));
}

TEST(Ply, TheFourthDegreeIsLeftOut) {
  std::vector<std::string> properties = kProperties;
  std::string row = "1 2 3 4 5 6 7 8 9 10 1 0 0 0";
  for (int i = 0; i < 72; ++i) {
    properties.push_back(fmt::format("f_rest_{}", i));
    row += fmt::format(" {}", i);
  }
  const auto scene = read(header("ascii", vertex(1, properties)) + row + "\n");
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->cloud.sh_degree, 3);
  EXPECT_EQ(scene->cloud.sh_rest[0], glm::vec3(0, 24, 48));
  EXPECT_EQ(scene->cloud.sh_rest[14], glm::vec3(14, 38, 62));
  EXPECT_THAT(scene->warnings, testing::ElementsAre(testing::HasSubstr("beyond degree 3")));
}

TEST(Ply, CountOfRestPropertiesDecidesTheDegree) {
  for (int count = 0; count <= 50; ++count) {
    std::vector<std::string> properties = kProperties;
    for (int i = 0; i < count; ++i) properties.push_back(fmt::format("f_rest_{}", i));
    const auto scene = read(header("binary_little_endian", vertex(0, properties)));
    if (count == 0 || count == 9 || count == 24 || count == 45) {
      ASSERT_TRUE(scene) << scene.error().message();
      EXPECT_EQ(3 * sh_rest_count(scene->cloud.sh_degree), count);
    } else {
      expect_error(scene, {fmt::format("has {} properties f_rest_*", count), "0, 9, 24, 45, 72"});
    }
  }
  std::vector<std::string> gap = kProperties;
  for (int i = 1; i <= 9; ++i) gap.push_back(fmt::format("f_rest_{}", i));
  expect_error(read(header("ascii", vertex(0, gap))), {"f_rest_0 is missing"});
}

TEST(Ply, MalformedHeadersAreExplained) {
  const std::string ok = vertex(0, kProperties);
  expect_error(read("plx\n"), {"header line 1", "expected \"ply\""});
  expect_error(read("ply\n" + ok + "end_header\n"), {"no \"format\""});
  expect_error(read("ply\nformat binary 1.0\n"), {"line 2", "binary_little_endian"});
  expect_error(read("ply\nformat ascii 2.0\n"), {"line 2", "format NAME 1.0"});
  expect_error(read(header("ascii", "property float x\n")), {"line 3", "before its properties"});
  expect_error(read(header("ascii", "element vertex 0\nproperty half x\n")), {"line 4", "scalar"});
  expect_error(read(header("ascii", "element vertex 0\nproperty list float int x\n")), {"line 4"});
  expect_error(read(header("ascii", "element vertex 0\nproperty list uchar int x\n")),
               {"element vertex", "list"});
  expect_error(read(header("ascii", ok + "property float x\n")), {"property x appears twice"});
  expect_error(read(header("ascii", "element face 0\n")), {"no element \"vertex\""});
  expect_error(read(header("ascii", "nonsense \x1b[31m\n")), {"line 3", "nonsense ?[31m"});
  expect_error(read(header("ascii", "element vertex 0\nproperty uint packed_position\n")),
               {"property x is missing", "3DGS .ply"});
  expect_error(read("ply\n" + std::string(2 << 20, 'a')), {"no \"end_header\"", "1048576"});
  expect_error(read(""), {"no \"end_header\""});
}

TEST(Ply, NonFiniteSplatsAreDroppedAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  SplatCloud cloud = random_cloud(10, 1);
  FLUXGS_UNWRAP(bytes, encode_ply(cloud, "x.ply"));
  const std::size_t row = 26 * 4, rows = bytes.size() - 10 * row;
  std::memcpy(&bytes[rows + 2 * row + 4], &nan, 4);            // y of splat 2
  std::memcpy(&bytes[rows + 5 * row + 25 * 4], &infinity, 4);  // last of the rotation of 5
  std::memcpy(&bytes[rows + 6 * row + 17 * 4], &nan, 4);       // last of f_rest of 6
  std::memcpy(&bytes[rows + 7 * row + 3 * 4], &nan, 4);        // nx of 7: of no interest
  FLUXGS_UNWRAP(scene, read_ply(bytes, "x.ply"));
  EXPECT_EQ(scene.dropped, 3u);
  ASSERT_EQ(scene.cloud.size(), 7u);
  EXPECT_EQ(scene.cloud.positions[2], cloud.positions[3]);
  EXPECT_EQ(scene.cloud.sh_rest[4 * 3], cloud.sh_rest[7 * 3]);
}

TEST(Ply, InfiniteLogitsAreOpacitiesOfZeroAndOne) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const SplatCloud cloud = random_cloud(4, 0);
  FLUXGS_UNWRAP(bytes, encode_ply(cloud, "x.ply"));
  const std::size_t row = 17 * 4, opacity = bytes.size() - 4 * row + 9 * 4;
  const float logits[] = {infinity, -infinity, nan};
  for (std::size_t i = 0; i < 3; ++i) std::memcpy(&bytes[opacity + i * row], &logits[i], 4);
  FLUXGS_UNWRAP(scene, read_ply(bytes, "x.ply"));
  EXPECT_EQ(scene.dropped, 1u);  // the NaN
  ASSERT_EQ(scene.cloud.size(), 3u);
  EXPECT_NEAR(scene.cloud.opacity_logits[0], 17.33, 0.01);
  EXPECT_NEAR(scene.cloud.opacity_logits[1], -87.34, 0.01);
  EXPECT_EQ(scene.cloud.opacity_logits[2], cloud.opacity_logits[3]);
}

TEST(Ply, WriterLeavesOutNonFiniteSplatsAndRefusesBrokenClouds) {
  SplatCloud cloud = random_cloud(4, 2);
  cloud.log_scales[1].y = std::numeric_limits<float>::infinity();
  FLUXGS_UNWRAP(bytes, encode_ply(cloud, "x.ply"));
  FLUXGS_UNWRAP(scene, read_ply(bytes, "x.ply"));
  EXPECT_EQ(scene.cloud.size(), 3u);
  EXPECT_EQ(scene.dropped, 0u);
  EXPECT_EQ(cloud.size(), 4u);
  cloud.sh_rest.pop_back();
  expect_error(encode_ply(cloud, "x.ply"), {"x.ply", "arrays disagree"});
  cloud.sh_degree = 4;
  expect_error(encode_ply(cloud, "x.ply"), {"sh_degree", "is 4"});
}

#ifndef __SANITIZE_ADDRESS__
[[noreturn]] void read_with_little_memory(const Bytes& data) {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t room = pages * static_cast<rlim_t>(::getpagesize()) + (20 << 20);
  const rlimit limit{room, room};
  setrlimit(RLIMIT_AS, &limit);
  const auto scene = read_ply(data, "huge.ply");
  std::fputs(scene ? "read" : scene.error().message().c_str(), stderr);
  std::_Exit(scene ? 1 : 0);
}
#endif

TEST(Ply, OutOfMemoryIsAnError) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer needs the address space";
#else
  // One byte per number in the file, four in memory: 56 MB are read, 224 MB are wanted.
  const std::size_t count = 4'000'000;
  Bytes data = bytes_of(header("binary_little_endian", vertex(count, kProperties, "uchar")));
  data.resize(data.size() + count * kProperties.size());
  EXPECT_EXIT(read_with_little_memory(data), testing::ExitedWithCode(0),
              "huge.ply: memory: out of memory: 224000000 bytes wanted");
#endif
}

// Damaged files may be read or refused, but nothing else (run under the sanitizers).
TEST(Ply, DamagedFilesNeverCrash) {
  FLUXGS_UNWRAP(bytes, encode_ply(random_cloud(2, 0), "x.ply"));
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    Bytes damaged = bytes;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = std::byte(random());
    if (random() % 4 == 0) damaged.resize(random() % damaged.size());
    const auto scene = read_ply(damaged, "x");
    if (scene) {
      EXPECT_EQ(count_non_finite(scene->cloud), 0u);
    }
  }
}

// The header of a small scene with these lines behind its second one.
Bytes ply_with(const std::string& lines) {
  const std::string text = text_of(*encode_ply(random_cloud(3, 0), "x"));
  const std::size_t at = text.find("element");
  return bytes_of(text.substr(0, at) + lines + text.substr(at));
}

TEST(Ply, CommentsNameTheFilter) {
  const auto filter_of = [](const std::string& lines) {
    const auto scene = read_ply(ply_with(lines), "x.ply");
    EXPECT_TRUE(scene) << lines;
    return scene ? scene->cloud.filter : ScreenFilter{};
  };
  const ScreenFilter classic, mip{.compensated = true}, narrow{0.1, true};
  EXPECT_EQ(filter_of(""), classic);
  for (const char* line : {"comment SplatRenderMode: mip\n", "comment   splatrendermode:MIP  \r\n",
                           "COMMENT SplatRenderMode = Mip\n", "comment\tSPLATRENDERMODE:\tmip\n",
                           "comment antialiased 1\n", "Comment Antialiased: 1\n",
                           "comment antialiased true\n", "comment train_flags antialiasing\n",
                           "comment SplatRenderMode: default\ncomment "
                           "antialiased 1\n",
                           "comment\ncomment \nobj_info x\ncomment SplatRenderMode: mip\n"})
    EXPECT_EQ(filter_of(line), mip) << line;
  for (const char* line :
       {"comment SplatRenderMode: default\n", "comment SplatRenderMode: 2dgs\n",
        "comment SplatRenderMode: banana\n", "comment SplatRenderMode\n", "comment antialiased 0\n",
        "comment antialiased\n", "comment antialiased 1 of 2 scenes\n",
        "comment is it antialiased 1\n", "comment SplatRenderMode: mip\ncomment antialiased 0\n",
        "comment train_flags none\n"})
    EXPECT_EQ(filter_of(line), classic) << line;
  EXPECT_EQ(filter_of("comment Exported from Brush\ncomment SplatRenderMode: mip\n"), narrow);
  EXPECT_EQ(filter_of("comment Exported from Brush\ncomment SplatRenderMode: default\n"), classic);
  EXPECT_EQ(filter_of("comment ScreenFilterDilation: 0.1\ncomment SplatRenderMode: mip\n"), narrow);
  for (const char* bad : {"0", "-1", "nan", "1e9", "x", ""})
    EXPECT_EQ(filter_of(fmt::format("comment ScreenFilterDilation: {}\n", bad)), classic) << bad;
}

TEST(Ply, CommentsAnywhereInTheHeader) {
  std::string text = text_of(*encode_ply(random_cloud(3, 0), "x"));
  const std::size_t end = text.find("end_header");
  text.insert(end, "comment SplatRenderMode: mip\n");
  FLUXGS_UNWRAP(last, read_ply(bytes_of(text), "x.ply"));
  EXPECT_TRUE(last.cloud.filter.compensated);
  text = text_of(*encode_ply(random_cloud(3, 0), "x"));
  text.insert(4, "comment antialiased 1\n");
  FLUXGS_UNWRAP(first, read_ply(bytes_of(text), "x.ply"));
  EXPECT_TRUE(first.cloud.filter.compensated);
}

TEST(Ply, TheFilterComesBack) {
  SplatCloud cloud = random_cloud(3, 1);
  for (const ScreenFilter filter :
       {ScreenFilter{}, ScreenFilter{0.3, true}, ScreenFilter{0.1, true}, ScreenFilter{0.15}}) {
    cloud.filter = filter;
    FLUXGS_UNWRAP(bytes, encode_ply(cloud, "x"));
    FLUXGS_UNWRAP(scene, read_ply(bytes, "x.ply"));
    EXPECT_EQ(scene.cloud.filter, filter);
    EXPECT_EQ(text_of(bytes).contains("comment SplatRenderMode: mip\n"), filter.compensated);
  }
}

}  // namespace
}  // namespace fluxgs
