// Scenes that are shown chunk by chunk, while their file is still on its way.
#include "unit/renderer/viewer/session_fixture.h"

#include <unistd.h>

#include <gmock/gmock.h>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf.h"
#include "tests/support/scenes.h"

namespace fluxgs::viewer {
namespace {

using namespace session_test;
using testing::HasSubstr;

using SessionChunksTest = SessionTest;

/// A compact file in chunks.
const std::vector<std::byte>& chunked_file() {
  static const std::vector<std::byte> file = [] {
    const SplatCloud cloud = test::random_cloud(25'000, 0, 3);
    const CompactOptions options{.steps = default_quantization_steps(cloud)};
    return *with_initial_view(*encode_compact_glb(cloud, options, "x"),
                              {.position = {0, 0, -4}, .fov_y = 0.8}, "x");
  }();
  return file;
}

/// A pipe, as another app sends a file.
struct SlowFile {
  int in = -1, out = -1;
  std::size_t sent = 0;
  SlowFile() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(::pipe(ends), 0);
    out = ends[0], in = ends[1];
  }
  ~SlowFile() { ::close(in); }
  void send_until(std::size_t end) {
    const auto& file = chunked_file();
    while (sent < end) {
      const auto put = ::write(in, file.data() + sent, end - sent);
      ASSERT_GT(put, 0);
      sent += static_cast<std::size_t>(put);
    }
  }
};

TEST_P(SessionChunksTest, ShowsASceneAfterATenthOfItsBytes) {
  const auto chunks = find_chunks(MemoryBytes(chunked_file()), "x");
  ASSERT_TRUE(chunks);
  ASSERT_EQ(chunks->size(), 4U);
  ASSERT_LE(chunks->front().end, chunked_file().size() / 10);
  SlowFile slow;
  session_->load(slow.out, "slow.glb", {});
  std::vector<Image<std::uint8_t>> images;
  for (std::size_t k = 0; k + 1 < chunks->size(); ++k) {
    slow.send_until((*chunks)[k].end);
    std::size_t splats = 0;
    for (std::size_t j = 0; j <= k; ++j) splats += (*chunks)[j].splats;
    ASSERT_TRUE(run_until([&](const SessionState& s) {
      return s.coarse && s.stats.shown == splats && s.stats.splats == 25'000U;
    })) << k
        << session_->state().error;
    const SessionState state = session_->state();
    EXPECT_EQ(state.loading.phase, LoadPhase::reading);
    EXPECT_FALSE(state.drawn) << "the app waits for the whole";
    EXPECT_GT(state.first_frame_ms, 0);
    EXPECT_EQ(state.shown, 0U);
    EXPECT_FALSE(session_->scene());
    images.push_back(image());
  }
  slow.send_until(chunked_file().size());
  ASSERT_TRUE(run_until([](const SessionState& s) { return s.drawn; }));
  EXPECT_FALSE(session_->state().coarse);
  const auto whole = image();
  const SavedView view = *session_->saved_view();

  begin();
  ASSERT_TRUE(load(chunked_file()));
  EXPECT_EQ(image().pixels, whole.pixels);
  EXPECT_EQ(session_->saved_view()->view.target, view.view.target);
  EXPECT_EQ(session_->saved_view()->view.distance, view.view.distance);
  for (std::size_t k = 1; k < images.size(); ++k)
    EXPECT_GT(psnr(images[k], whole), psnr(images[k - 1], whole)) << k;
  EXPECT_GT(psnr(images.front(), whole), 15);
}

TEST_P(SessionChunksTest, TheSceneBeforeStaysUntilAllHasCome) {
  ASSERT_TRUE(load(file_with_start()));
  const auto before = image();
  const auto chunks = *find_chunks(MemoryBytes(chunked_file()), "x");
  SlowFile slow;
  session_->load(slow.out, "slow.glb", {});
  slow.send_until(chunks[2].end);
  ASSERT_TRUE(run_until([&](const SessionState& s) { return s.loading.read >= chunks[2].end; }));
  EXPECT_EQ(image().pixels, before.pixels);
  EXPECT_TRUE(session_->state().drawn);
  slow.send_until(chunked_file().size());
  ASSERT_TRUE(run_until([](const SessionState& s) { return s.shown == 2; }));
  EXPECT_GT(session_->scene()->size(), 20'000U);
}

// The chunks that had come stay shown, beside the error.
TEST_P(SessionChunksTest, AFileThatIsCutShowsWhatCame) {
  const auto chunks = *find_chunks(MemoryBytes(chunked_file()), "x");
  {
    SlowFile slow;
    session_->load(slow.out, "slow.glb", {});
    slow.send_until(chunks[0].end);
    ASSERT_TRUE(run_until([](const SessionState& s) { return s.coarse; }));
    slow.send_until(chunks[0].end + 100);
  }
  ASSERT_TRUE(
      run_until([](const SessionState& s) { return s.loading.phase == LoadPhase::failed; }));
  EXPECT_THAT(session_->state().loading.error, HasSubstr("slow.glb: read: ended after"));
  EXPECT_TRUE(session_->state().coarse);
  EXPECT_FALSE(session_->state().drawn);
  EXPECT_FALSE(session_->state().has_scene);
  ASSERT_TRUE(load(file_with_start()));
  EXPECT_FALSE(session_->state().coarse);
}

FLUXGS_GL_TEST_SUITE(SessionChunksTest);

}  // namespace
}  // namespace fluxgs::viewer
