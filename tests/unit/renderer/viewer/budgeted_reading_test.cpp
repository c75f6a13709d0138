// Scenes larger than the memory for them: harmonics go first, then the splats that add least.
#include "viewer/budgeted_reading.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/morton.h"
#include "render/splat_budget.h"
#include "tests/support/scenes.h"

namespace fluxgs::viewer {
namespace {

using render::RenderCloud;
using testing::HasSubstr;

constexpr std::size_t kSplats = 40'000;

void expect_same(const RenderCloud& a, const RenderCloud& b, const std::string& label) {
  EXPECT_EQ(a.sh_degree, b.sh_degree) << label;
  EXPECT_TRUE(a.base.positions == b.base.positions && a.base.log_scales == b.base.log_scales &&
              a.base.rotations == b.base.rotations &&
              a.base.opacity_logits == b.base.opacity_logits && a.base.sh_dc == b.base.sh_dc &&
              a.sh == b.sh)
      << label;
}

Expected<LoadedScene> read(std::span<const std::byte> bytes, std::uint64_t memory) {
  const auto format = recognise_scene(bytes, "scene");
  if (!format) return std::unexpected(format.error());
  return read_within(memory, **format, MemoryBytes(bytes), "scene");
}

TEST(PlanScene, LowersTheDegreeThenLeavesOutSplats) {
  const ComingSplats coming{.count = 1'000'000, .sh_degree = 3};
  const auto plan = [&](std::uint64_t memory) {
    const ScenePlan p = plan_scene(coming, memory);
    return std::pair(p.count, p.sh_degree);
  };
  EXPECT_EQ(plan(146'000'000), std::pair(1'000'000UL, 3));  // 56 and 90 bytes a splat
  EXPECT_EQ(plan(145'999'999), std::pair(1'000'000UL, 2));
  EXPECT_EQ(plan(104'000'000), std::pair(1'000'000UL, 2));
  EXPECT_EQ(plan(103'999'999), std::pair(1'000'000UL, 1));
  EXPECT_EQ(plan(74'000'000), std::pair(1'000'000UL, 1));
  EXPECT_EQ(plan(73'999'999), std::pair(891'891UL, 1));  // 8 MB for ranking
  EXPECT_EQ(plan(8'000'000).first, 0U);
  EXPECT_EQ(plan(0).first, 0U);
  EXPECT_EQ(plan_scene({.count = 1000, .sh_degree = 0}, 56'000).count, 1000U);
}

TEST(ReadWithin, AllOfItInOrder) {
  SplatCloud cloud = test::random_cloud(kSplats, 2);
  cloud.filter = {.dilation = 0.1, .compensated = true};
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    const auto bytes = format.encode(cloud, "scene", {});
    ASSERT_TRUE(bytes);
    const auto whole = read_scene(*bytes, "scene");
    const auto read_in = read(*bytes, 1 << 30);
    ASSERT_TRUE(whole && read_in) << format.name;
    RenderCloud expected = whole->cloud;
    put_in_order(expected);
    expect_same(read_in->cloud, expected, std::string(format.name));
    EXPECT_EQ(read_in->cloud.base.filter, whole->cloud.filter) << format.name;
    EXPECT_EQ(read_in->cloud.file_splats, kSplats);
    EXPECT_EQ(read_in->cloud.file_sh_degree, whole->cloud.sh_degree);
  }
}

// In every format, and whatever is dropped.
TEST(ReadWithin, KeepsTheSplatsThatAddMost) {
  SplatCloud cloud = test::random_cloud(kSplats, 3);
  for (std::size_t i = 0; i < 100; ++i)
    cloud.log_scales[7 * i] = cloud.log_scales[0];  // equal ones
  for (std::size_t i = 0; i < 100; ++i) cloud.opacity_logits[7 * i] = cloud.opacity_logits[0];
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    auto bytes = format.encode(cloud, "scene", {});
    ASSERT_TRUE(bytes);
    if (format.name == "ply") {  // a NaN in the harmonics of the third splat of the file
      const float nan = std::nanf("");
      std::copy_n(reinterpret_cast<const std::byte*>(&nan), 4,
                  bytes->end() - 248 * (kSplats - 2) + 40);
    }
    const auto whole = read_scene(*bytes, "scene");
    ASSERT_TRUE(whole) << format.name;
    EXPECT_EQ(whole->dropped, format.name == "ply" ? 1U : 0U);
    const int degree = std::min(whole->cloud.sh_degree, 1);
    const bool decodes_all = format.name == "glb" || format.name == "spz" || format.name == "sog";
    const std::uint64_t memory = render::render_cloud_bytes(degree) * 25'000 + 8 * kSplats;
    const auto some = read(*bytes, memory);
    if (!some && decodes_all) {  // what it unpacks does not fit
      EXPECT_THAT(some.error().message(), HasSubstr("memory: needs about")) << format.name;
      continue;
    }
    ASSERT_TRUE(some) << format.name << some.error().message();
    SplatCloud kept = in_order(whole->cloud, render::max_contributing(whole->cloud, 25'000));
    limit_sh_degree(kept, degree);
    RenderCloud expected = kept;
    put_in_order(expected);
    expect_same(some->cloud, expected, std::string(format.name));
    EXPECT_EQ(some->cloud.file_splats, kSplats - whole->dropped);
    EXPECT_EQ(some->cloud.file_sh_degree, whole->cloud.sh_degree);
    EXPECT_EQ(some->dropped, whole->dropped);
  }
}

TEST(ReadWithin, ATwentiethOfTheSplatsIsTheLeast) {
  const auto bytes = encode_ply(test::random_cloud(kSplats, 0), "scene");
  ASSERT_TRUE(bytes);
  const std::uint64_t ranking = 8 * kSplats, least = 56 * kSplats / 20;
  EXPECT_TRUE(read(*bytes, ranking + least));
  const auto refused = read(*bytes, ranking + least - 56);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("scene: memory: needs about 0.1 MB"));
}

/// Another file when it is read again.
class Changing final : public ByteSource {
 public:
  Changing(std::span<const std::byte> first, std::span<const std::byte> then)
      : first_(first), then_(then) {}
  std::uint64_t size() const override { return now().size(); }
  Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                            std::vector<std::byte>& room) const override {
    return MemoryBytes(now()).read(at, count, room);
  }
  void change() { changed_ = true; }

 private:
  std::span<const std::byte> now() const { return changed_ ? then_ : first_; }
  std::span<const std::byte> first_, then_;
  bool changed_ = false;
};

TEST(ReadWithin, AFileThatChangesBetweenTheReadingsIsRefused) {
  const auto first = encode_ply(test::random_cloud(kSplats, 0), "scene");
  SplatCloud sound = test::random_cloud(kSplats + 1, 0);
  const auto more = encode_ply(sound, "scene");
  sound.resize(kSplats);
  auto broken = *first;  // first there were fewer finite ones
  const float nan = std::nanf("");
  std::copy_n(reinterpret_cast<const std::byte*>(&nan), 4, broken.end() - 68);
  const std::uint64_t memory = 56 * kSplats / 2;
  const auto format = recognise_scene(*first, "scene");
  const auto read_changing = [&](std::span<const std::byte> a, std::span<const std::byte> b) {
    Changing source(a, b);
    return read_within(memory, **format, source, "scene", {}, [&] { source.change(); });
  };
  for (const auto& refused : {read_changing(*first, *more), read_changing(broken, *first)}) {
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message(), HasSubstr("has changed while it was read"));
  }
  EXPECT_TRUE(read_changing(*first, *first));
  EXPECT_TRUE(read_changing(*first, broken)) << "one that is less is no harm";
}

}  // namespace
}  // namespace fluxgs::viewer
