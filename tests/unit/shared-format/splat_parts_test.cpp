// Scenes read part by part, from memory and from files: the same splats as in one cloud.
#include <fcntl.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <functional>

#include <fmt/format.h>

#include "fluxgs/byte_source.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/scene.h"
#include "support.h"

namespace fluxgs {
namespace {

using namespace test;

/// Keeps what comes, as far as a degree.
class Parts : public SplatSink {
 public:
  explicit Parts(int max_degree = 3) : max_degree_(max_degree) {}

  Expected<int> begin(const ComingSplats& coming) override {
    came = coming;
    cloud.sh_degree = std::min(coming.sh_degree, max_degree_);
    return cloud.sh_degree;
  }
  Expected<void> take(SplatCloud& part) override {
    if (on_part) on_part();
    if (fails) return fail("sink", "", "is full");
    largest = std::max(largest, part.size());
    EXPECT_LE(part.sh_degree, cloud.sh_degree);
    const auto rest = static_cast<std::size_t>(sh_rest_count(part.sh_degree));
    const auto wanted = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
    for (std::size_t i = 0; i < part.size(); ++i) {
      cloud.positions.push_back(part.positions[i]);
      cloud.log_scales.push_back(part.log_scales[i]);
      cloud.rotations.push_back(part.rotations[i]);
      cloud.opacity_logits.push_back(part.opacity_logits[i]);
      cloud.sh_dc.push_back(part.sh_dc[i]);
      for (std::size_t k = 0; k < wanted; ++k)
        cloud.sh_rest.push_back(k < rest ? part.sh_rest[i * rest + k] : glm::vec3(0));
    }
    return {};
  }

  SplatCloud cloud;
  ComingSplats came;
  std::size_t largest = 0;
  bool fails = false;
  std::function<void()> on_part;

 private:
  int max_degree_;
};

void expect_same(const SplatCloud& a, const SplatCloud& b, const std::string& label) {
  EXPECT_EQ(a.sh_degree, b.sh_degree) << label;
  EXPECT_TRUE(a.positions == b.positions && a.log_scales == b.log_scales &&
              a.rotations == b.rotations && a.opacity_logits == b.opacity_logits &&
              a.sh_dc == b.sh_dc && a.sh_rest == b.sh_rest)
      << label;
}

/// A file without a name, with a few bytes before and behind.
class OpenFile {
 public:
  explicit OpenFile(const Bytes& bytes) : file_(std::tmpfile()), size_(bytes.size()) {
    std::fwrite("before", 1, kBefore, file_);
    std::fwrite(bytes.data(), 1, bytes.size(), file_);
    std::fwrite("behind", 1, 6, file_);
    std::fflush(file_);
  }
  ~OpenFile() { std::fclose(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  FileBytes bytes() const { return {::fileno(file_), kBefore, size_, "scene"}; }
  void cut(std::size_t size) const {
    EXPECT_EQ(::ftruncate(::fileno(file_), static_cast<off_t>(kBefore + size)), 0);
  }

 private:
  static constexpr std::size_t kBefore = 6;
  std::FILE* file_;
  std::size_t size_;
};

void expect_parts_as_whole(const Bytes& bytes, const std::string& label) {
  FLUXGS_UNWRAP(whole, read_scene(bytes, "scene"));
  FLUXGS_UNWRAP(format, recognise_scene(bytes, "scene"));
  const OpenFile file(bytes);
  for (const int degree : {3, 1, 0}) {
    SplatCloud expected = whole.cloud;
    limit_sh_degree(expected, degree);
    Parts in_memory(degree), from_file(degree);
    FLUXGS_UNWRAP(scene, read_scene(*format, MemoryBytes(bytes), "scene", in_memory));
    expect_same(in_memory.cloud, expected, label);
    EXPECT_EQ(scene.cloud.size(), 0U) << label;
    EXPECT_EQ(scene.cloud.sh_degree, expected.sh_degree) << label;
    EXPECT_EQ(scene.cloud.filter, whole.cloud.filter) << label;
    EXPECT_EQ(scene.dropped, whole.dropped) << label;
    EXPECT_EQ(scene.attribute_bits, whole.attribute_bits) << label;
    EXPECT_EQ(in_memory.came.count, whole.cloud.size() + whole.dropped) << label;
    EXPECT_EQ(in_memory.came.sh_degree, whole.cloud.sh_degree) << label;
    FLUXGS_UNWRAP(again, read_scene(*format, file.bytes(), "scene", from_file));
    expect_same(from_file.cloud, expected, label);
    EXPECT_EQ(again.bytes, bytes.size()) << label;
    if (format->name == "glb") continue;
    EXPECT_LE(in_memory.largest, kSplatsOfAPart) << label;
  }
}

/// Two parts and a bit, of mixed degrees, some of them not finite.
SplatCloud large_cloud() {
  SplatCloud cloud = random_cloud(2 * kSplatsOfAPart + 300, 3);
  for (std::size_t i = 0; i < cloud.sh_rest.size(); ++i)
    if (i % 45 > 20) cloud.sh_rest[i] = glm::vec3(0);
  cloud.filter = {.dilation = 0.1, .compensated = true};
  return cloud;
}

TEST(SplatParts, AreTheSameSplatsInEveryFormat) {
  const SplatCloud cloud = large_cloud();
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    FLUXGS_UNWRAP(bytes, format.encode(cloud, "scene", {}));
    expect_parts_as_whole(bytes, std::string(format.name));
  }
  FLUXGS_UNWRAP(compact, encode_compact_glb(cloud, {}, "scene"));
  expect_parts_as_whole(compact, "compact");
}

/// A .ply with an element of lists in front, written as the encoding says.
Bytes odd_ply(const std::string& encoding, std::size_t splats) {
  std::string text = fmt::format(
      "ply\nformat {} 1.0\nelement odd 30000\nproperty list uchar int i\n"
      "element vertex {}\n",
      encoding, splats);
  for (const char* name : {"x", "y", "z", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
                           "rot_1", "rot_2", "rot_3", "f_dc_0", "f_dc_1", "f_dc_2"})
    text += fmt::format("property float {}\n", name);
  Bytes bytes = bytes_of(text + "end_header\n");
  const bool big = encoding == "binary_big_endian";
  const auto put = [&](const auto& value) {
    if (encoding == "ascii") {
      const Bytes word = bytes_of(fmt::format("{}{}", value, value == 7 ? "   \n" : " "));
      bytes.insert(bytes.end(), word.begin(), word.end());
      return;
    }
    Bytes raw;
    append(raw, value);
    if (big) std::ranges::reverse(raw);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  };
  for (int i = 0; i < 30000; ++i) {
    put(static_cast<std::uint8_t>(i % 4));
    for (int k = 0; k < i % 4; ++k) put(std::int32_t{k});
  }
  for (std::size_t i = 0; i < splats; ++i)
    for (int k = 0; k < 14; ++k)
      put(i == 77 && k == 2 ? std::nanf("") : static_cast<float>(i % 1000) + 0.125f * k);
  return bytes;
}

// Longer than what is read at once.
TEST(SplatParts, OfPlysOfAnyEncoding) {
  for (const char* encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const Bytes bytes = odd_ply(encoding, kSplatsOfAPart + 5000);
    ASSERT_GT(bytes.size(), 1'200'000U);
    expect_parts_as_whole(bytes, encoding);
  }
}

TEST(SplatParts, AFileThatIsCutWhileItIsReadIsAnError) {
  for (const char* name : {"ply", "splat", "spz"}) {
    const auto format = std::ranges::find(scene_formats(), name, &SceneFormat::name);
    FLUXGS_UNWRAP(bytes, format->encode(large_cloud(), "scene", {}));
    const OpenFile file(bytes);
    file.cut(bytes.size() / 2);
    Parts parts;
    expect_error(read_scene(*format, file.bytes(), "scene", parts),
                 {"scene", "read", fmt::format("of {} bytes: it was cut", bytes.size())});
  }
  const auto ply = std::ranges::find(scene_formats(), "ply", &SceneFormat::name);
  FLUXGS_UNWRAP(bytes, ply->encode(large_cloud(), "scene", {}));
  const OpenFile file(bytes);
  Parts parts;
  parts.on_part = [&] { file.cut(bytes.size() / 2); };  // when some of it has been read
  expect_error(read_scene(*ply, file.bytes(), "scene", parts), {"scene", "read", "it was cut"});
  EXPECT_GT(parts.cloud.size(), 0U);
}

TEST(SplatParts, ASinkThatIsFullEndsTheReading) {
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    FLUXGS_UNWRAP(bytes, format.encode(random_cloud(1000, 1), "scene", {}));
    Parts parts;
    parts.fails = true;
    expect_error(read_scene(format, MemoryBytes(bytes), "scene", parts), {"sink", "is full"});
  }
}

}  // namespace
}  // namespace fluxgs
