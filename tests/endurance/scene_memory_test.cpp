// Opening a scene does not take another one's memory for a while: where a scene just fits, the
// system would end the app.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "allocations.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/io/scene_estimate.h"
#include "render/scene_view.h"
#include "unit/renderer/gl_fixture.h"
#include "unit/renderer/scenes.h"
#include "viewer/decode_memory_guard.h"
#include "viewer/scene_loading.h"

namespace fluxgs::test {
namespace {

TEST(SceneMemoryTest, DecodingTakesNoMoreThanAsMuchAgain) {
  if (kSanitized) GTEST_SKIP() << "its own allocations are not seen";
  const SplatCloud cloud = random_cloud(100'000, 3, 5);
  const auto expect_it = [&](std::string_view format, const std::vector<std::byte>& bytes) {
    const auto estimate = must(estimate_scene(bytes, "scene"));
    const long before = allocations.bytes;
    allocations.max_bytes = before;
    const auto scene = must(read_scene(bytes, "scene"));
    const auto most = static_cast<double>(allocations.max_bytes - before);
    const auto estimated = static_cast<double>(estimate.decoded);
    std::printf("%s: %.1f MB, decoded %.1f MB: %.1f MB at most\n", std::string(format).c_str(),
                1e-6 * static_cast<double>(bytes.size()), 1e-6 * estimated, 1e-6 * most);
    EXPECT_LT(most, 2 * estimated) << format;  // what FreeMemory.kt counts on
    EXPECT_GE(most, 0.99 * estimated) << format << ": less than the scene was counted";
  };
  for (const SceneFormat& format : scene_formats())
    if (format.encode != nullptr) expect_it(format.name, must(format.encode(cloud, "scene", {})));
  expect_it("compact", must(encode_compact_glb(cloud, {}, "scene")));
}

/// Otherwise another one, or the same, is refused for want of memory that is about to be free.
TEST(SceneMemoryTest, WhatACancelledSceneHoldsCanBeWaitedFor) {
  if (kSanitized) GTEST_SKIP() << "its own allocations are not seen";
  using viewer::LoadPhase;
  const auto bytes = must(encode_compact_glb(random_cloud(100'000, 3, 5), {}, "scene"));
  std::FILE* file = std::tmpfile();
  ASSERT_EQ(std::fwrite(bytes.data(), 1, bytes.size(), file), bytes.size());
  std::fflush(file);
  const long before = allocations.bytes;

  const auto cancelled_while_it_decodes = [&] {
    std::rewind(file);
    viewer::SceneLoading loading;
    loading.begin(::dup(::fileno(file)), "scene.glb", {});
    LoadPhase phase = LoadPhase::reading;
    while (phase == LoadPhase::reading ||
           (phase == LoadPhase::decoding && allocations.bytes - before < 10'000'000)) {
      std::this_thread::yield();
      phase = loading.state().phase;
    }
    loading.cancel();
    return phase == LoadPhase::decoding && allocations.bytes - before > 1'000'000;
  };
  bool caught = false;  // a busy machine may look too late
  for (int tries = 0; tries < 20 && !caught; ++tries) {
    caught = cancelled_while_it_decodes();
    viewer::DecodeMemoryGuard::wait_for_none();
    ASSERT_LT(allocations.bytes - before, 100'000);
  }
  EXPECT_TRUE(caught);
  std::fclose(file);
}

class UploadMemoryTest : public GlTest {};

TEST_P(UploadMemoryTest, NoCopyOfTheSceneIsMade) {
  if (kSanitized) GTEST_SKIP() << "its own allocations are not seen";
  constexpr std::size_t kSplats = 200'000;
  const auto cloud = std::make_shared<const render::RenderCloud>(random_cloud(kSplats, 3, 5));
  constexpr long kSceneBytes = 160L * kSplats;  // on the GPU
  for (const std::size_t shown : {kSplats, kSplats / 2}) {
    render::SceneView view(cloud, {.max_splats = shown});
    const long before = allocations.bytes;
    allocations.max_bytes = before;
    must(view.open(device(), 64, 48));
    EXPECT_EQ(view.splats(), shown);
    const long most = allocations.max_bytes - before, after = allocations.bytes - before;
    std::printf("%zu of %zu splats, %ld bytes on the GPU: %ld bytes at most, %ld afterwards\n",
                shown, kSplats, kSceneBytes, most, after);
    // 12 bytes a splat are ranked, and a part of 2.6 MB at a time is packed
    EXPECT_LT(most, kSceneBytes / 5);
    EXPECT_GT(most, 2'500'000) << "nothing was counted";
  }
}

FLUXGS_GL_TEST_SUITE(UploadMemoryTest);

}  // namespace
}  // namespace fluxgs::test
