// Compact files in chunks: the first bytes show the scene, and damage to the chunks is named.
#include <algorithm>
#include <functional>

#include <nlohmann/json.hpp>

#include "fluxgs/contribution.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/scene.h"
#include "glb_support.h"

namespace fluxgs {
namespace {

using namespace test;
using nlohmann::json;

constexpr std::size_t kSplats = 25'000;
constexpr char kExtension[] = "FLUXGS_gaussian_splatting_compact";

const SplatCloud& large_cloud() {
  static const SplatCloud cloud = random_cloud(kSplats, 1);
  return cloud;
}
CompactOptions options_of(const SplatCloud& cloud, bool in_chunks = true) {
  return {.steps = default_quantization_steps(cloud), .in_chunks = in_chunks};
}
const Bytes& large_file() {
  static const Bytes file =
      *encode_compact_glb(large_cloud(), options_of(large_cloud()), "large.glb");
  return file;
}

/// The first bytes of a file, the rest of which never comes.
class FirstBytes final : public ByteSource {
 public:
  FirstBytes(const Bytes& file, std::size_t there) : file_(file), there_(there) {}
  std::uint64_t size() const override { return file_.size(); }
  Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                            std::vector<std::byte>&) const override {
    if (at + count > there_) return fail("file", "read", "ended");
    return std::span(file_).subspan(static_cast<std::size_t>(at), count);
  }

 private:
  const Bytes& file_;
  std::size_t there_;
};

/// What came until the end of each chunk but the last, and what came in all.
class ChunkSink final : public SplatSink {
 public:
  Expected<int> begin(const ComingSplats& coming) override {
    coming_ = coming;
    return coming.sh_degree;
  }
  Expected<void> take(SplatCloud& part) override {
    positions.insert(positions.end(), part.positions.begin(), part.positions.end());
    return {};
  }
  void chunk_came(const SceneFile& so_far) override {
    whole.push_back(positions.size());
    chunks = so_far.chunks;
  }

  std::vector<glm::vec3> positions;
  std::vector<std::size_t> whole;
  std::vector<SceneChunk> chunks;

 private:
  ComingSplats coming_;
};

json primitives_of(const Bytes& glb) {
  return json::parse(json_of(glb)).at("meshes").at(0).at("primitives");
}

TEST(CompactChunks, ThoseThatAddMostComeFirst) {
  const auto scene = read(large_file());
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->chunks.size(), 4u);
  EXPECT_LE(scene->chunks[0].end, large_file().size() / 10);
  EXPECT_LE(scene->chunks[3].end, large_file().size());
  EXPECT_GT(scene->chunks[3].end + 4, large_file().size()) << "but for padding";
  const std::vector<std::uint32_t> order = compact_order(large_cloud(), options_of(large_cloud()));
  ASSERT_EQ(order.size(), kSplats);
  std::size_t begin = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const SceneChunk& chunk : scene->chunks) {
    double most = 0, own_least = least;
    for (std::size_t k = begin; k < begin + chunk.splats; ++k) {
      const double value = contribution(large_cloud(), order[k]);
      most = std::max(most, value);
      own_least = std::min(own_least, value);
    }
    EXPECT_LE(most, least * (1 + 1e-6));
    least = own_least;
    begin += chunk.splats;
  }
  EXPECT_EQ(begin, kSplats);
  for (std::size_t k = 0; k < kSplats; k += 7)
    ASSERT_LT(glm::distance(scene->cloud.positions[k], large_cloud().positions[order[k]]), 0.1f);
}

TEST(CompactChunks, TakeNoMoreBytesThanOneStream) {
  const Bytes one = *encode_compact_glb(large_cloud(), options_of(large_cloud(), false), "one.glb");
  EXPECT_LT(static_cast<double>(large_file().size()), 1.02 * static_cast<double>(one.size()));
  const auto scene = read(one);
  ASSERT_TRUE(scene);
  EXPECT_TRUE(scene->chunks.empty());
  EXPECT_EQ(primitives_of(one).size(), 1u);
  EXPECT_FALSE(json_of(one).contains("\"chunk\""));
}

TEST(CompactChunks, SmallScenesAndThoseOfManyDegreesAreOne) {
  for (const std::size_t count : {0, 1, 20'000}) {
    const SplatCloud small = random_cloud(count, 0);
    const auto scene = read(*encode_compact_glb(small, options_of(small), "x"));
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_TRUE(scene->chunks.empty());
    EXPECT_EQ(scene->cloud.size(), count);
  }
  SplatCloud mixed = random_cloud(kSplats, 1);
  for (std::size_t i = 0; i < kSplats; i += 2)
    for (std::size_t k = 3 * i; k < 3 * (i + 1); ++k) mixed.sh_rest[k] = glm::vec3(0);
  EXPECT_TRUE(read(*encode_compact_glb(mixed, options_of(mixed), "x"))->chunks.empty());
}

// At each end of a chunk, a byte before, and wherever else a file may be cut.
TEST(CompactChunks, WhatHasComeIsRead) {
  const auto whole = read(large_file());
  ASSERT_TRUE(whole);
  const auto chunks = find_chunks(FirstBytes(large_file(), 10'000), "x");
  ASSERT_TRUE(chunks) << chunks.error().message();
  ASSERT_EQ(chunks->size(), 4u);
  std::vector<std::size_t> cuts{0, 3, 11, 19, 500, large_file().size()};
  for (const SceneChunk& chunk : *chunks) cuts.insert(cuts.end(), {chunk.end - 1, chunk.end});
  for (std::size_t cut = 777; cut < large_file().size(); cut += large_file().size() / 9)
    cuts.push_back(cut);
  for (const std::size_t cut : cuts) {
    ChunkSink sink;
    const auto scene = read_glb(FirstBytes(large_file(), cut), "x", sink);
    EXPECT_EQ(scene.has_value(), cut >= chunks->back().end) << cut;
    std::size_t expected = 0, ended = 0;
    for (const SceneChunk& chunk : *chunks)
      if (chunk.end <= cut) expected += chunk.splats, ++ended;
    ASSERT_EQ(sink.positions.size(), expected) << cut;
    EXPECT_EQ(sink.whole.size(), std::min<std::size_t>(ended, 3)) << cut;
    EXPECT_TRUE(
        std::equal(sink.positions.begin(), sink.positions.end(), whole->cloud.positions.begin()))
        << cut;
  }
}

TEST(CompactChunks, PlainAttributesLieWithTheirChunk) {
  CompactOptions options = options_of(large_cloud());
  options.plain_attributes = true;
  const Bytes both = *encode_compact_glb(large_cloud(), options, "both.glb");
  const auto with_plain = read(both), compact = read(large_file());
  const auto plain = read(edited(both, kExtension, "OTHERS_gaussian_splatting_unknown"));
  ASSERT_TRUE(with_plain && compact);
  EXPECT_EQ(with_plain->chunks.size(), 4u);
  EXPECT_LE(with_plain->chunks[0].end, both.size() / 10);
  EXPECT_EQ(with_plain->cloud.positions, compact->cloud.positions);
}

TEST(CompactChunks, ShownTwiceTheyAreOne) {
  json root = json::parse(json_of(large_file()));
  root["nodes"].push_back(root["nodes"][0]);
  root["scenes"][0]["nodes"].push_back(1);
  const auto scene = read(make_glb(root.dump(), bin_of(large_file())));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->cloud.size(), 2 * kSplats);
  EXPECT_TRUE(scene->chunks.empty());
}

// A file of before, and of a program that knows no chunks.
TEST(CompactChunks, FilesWithoutNumbersAreOneChunk) {
  json root = json::parse(json_of(large_file()));
  for (json& primitive : root["meshes"][0]["primitives"])
    primitive["extensions"]["KHR_gaussian_splatting"]["extensions"][kExtension].erase("chunk");
  const auto scene = read(make_glb(root.dump(), bin_of(large_file())));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_TRUE(scene->chunks.empty());
  EXPECT_EQ(scene->cloud.positions, read(large_file())->cloud.positions);
}

TEST(CompactChunks, DamageIsNamed) {
  const auto damaged = [](const std::function<void(json & root)>& damage) {
    json root = json::parse(json_of(large_file()));
    damage(root);
    const auto scene = read(make_glb(root.dump(), bin_of(large_file())));
    return scene ? std::string("was read") : scene.error().message();
  };
  const auto numbered = [&](std::size_t primitive, const json& number) {
    return damaged([&](json& root) {
      root["meshes"][0]["primitives"][primitive]["extensions"]["KHR_gaussian_splatting"]
          ["extensions"][kExtension]["chunk"] = number;
    });
  };
  const auto view = [&](const char* key, std::size_t index, std::size_t value) {
    return damaged([&](json& root) { root["bufferViews"][index][key] = value; });
  };
  const std::string place = "test.glb: meshes[0].primitives";
  EXPECT_EQ(numbered(0, 1), place + "[0]: is of chunk 1; expected 0, as the first");
  EXPECT_EQ(numbered(1, 3), place + "[1]: is of chunk 3; expected 0 or 1");
  EXPECT_EQ(numbered(2, 0), place + "[2]: is of chunk 0; expected 1 or 2");
  for (const json& number : {json(-1), json(1.5), json("1"), json(4294967295u), json(1e300)})
    EXPECT_NE(numbered(1, number).find("chunk: is"), std::string::npos) << number;
  EXPECT_NE(view("byteOffset", 1, 0).find("[1]: of chunk 1 lies at 0"), std::string::npos);
  EXPECT_NE(view("byteOffset", 2, 4).find("[2]: of chunk 2 lies at"), std::string::npos);
  EXPECT_NE(view("byteLength", 0, bin_of(large_file()).size()).find("[1]: of chunk 1 lies at"),
            std::string::npos);
  EXPECT_NE(view("byteLength", 3, ~std::size_t{0} >> 12).find("outside the buffer"),
            std::string::npos);
  EXPECT_NE(view("byteLength", 3, 100).find("splats in 100 bytes"), std::string::npos);
  EXPECT_NE(view("buffer", 1, 1).find("buffers[1]: does not exist"), std::string::npos);
}

}  // namespace
}  // namespace fluxgs
