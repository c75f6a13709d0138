// Reading scenes from descriptors: files, pipes, providers that stall, hostile content.
#include "viewer/scene_loading.h"

#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fluxgs/io/gltf.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/io/splat.h"
#include "tests/support/scenes.h"

namespace fluxgs::viewer {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

LoadState settled(const SceneLoading& loading) {
  for (int i = 0; i < 1000; ++i) {
    const LoadState state = loading.state();
    if (state.phase != LoadPhase::reading && state.phase != LoadPhase::decoding) return state;
    std::this_thread::sleep_for(10ms);
  }
  return loading.state();
}

std::vector<std::byte> scene_bytes() { return *encode_glb(test::random_cloud(500, 1), "scene"); }

/// A file without a name that holds these bytes.
int file_of(const std::vector<std::byte>& bytes) {
  std::FILE* file = std::tmpfile();
  if (!bytes.empty()) std::fwrite(bytes.data(), 1, bytes.size(), file);
  std::fflush(file);
  const int descriptor = ::dup(::fileno(file));
  std::fclose(file);
  ::lseek(descriptor, 0, SEEK_SET);
  return descriptor;
}

struct Pipe {
  int in = -1, out = -1;
  Pipe() {
    int ends[2] = {-1, -1};
    EXPECT_EQ(::pipe(ends), 0);
    out = ends[0];
    in = ends[1];
  }
};

bool is_open(int descriptor) { return ::fcntl(descriptor, F_GETFD) != -1; }

TEST(SceneLoading, ReadsAFile) {
  SceneLoading loading;
  EXPECT_EQ(loading.state().phase, LoadPhase::idle);
  const int descriptor = file_of(scene_bytes());
  loading.begin(descriptor, "scene.glb", {});
  const LoadState state = settled(loading);
  ASSERT_EQ(state.phase, LoadPhase::ready) << state.error;
  EXPECT_EQ(state.bytes, scene_bytes().size());
  EXPECT_EQ(state.read, state.bytes);
  EXPECT_EQ(state.estimate->splats, 500U);
  const auto scene = loading.take();
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->cloud.size(), 500U);
  EXPECT_FALSE(loading.take()) << "once";
  loading.cancel();
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(is_open(descriptor));
}

TEST(SceneLoading, ReadsAPipe) {
  SceneLoading loading;
  Pipe pipe;
  loading.begin(pipe.out, "shared", {});
  const auto bytes = scene_bytes();
  std::thread writer([&] {
    std::size_t done = 0;
    while (done < bytes.size()) {
      const auto put =
          ::write(pipe.in, bytes.data() + done, std::min<std::size_t>(1000, bytes.size() - done));
      ASSERT_GT(put, 0);
      done += static_cast<std::size_t>(put);
    }
    ::close(pipe.in);
  });
  const LoadState state = settled(loading);
  writer.join();
  ASSERT_EQ(state.phase, LoadPhase::ready) << state.error;
  EXPECT_EQ(state.bytes, 0U) << "a pipe does not say";
}

// The provider says how many bytes there are.
TEST(SceneLoading, APipeOfAnnouncedSize) {
  const auto bytes = *encode_splat(test::random_cloud(1000, 0), "scene");
  const auto send = [&](std::uint64_t announced, std::size_t sent, std::uint64_t memory) {
    SceneLoading loading;
    Pipe pipe;
    loading.begin(pipe.out, "garden.splat", {.memory = memory, .announced = announced});
    EXPECT_EQ(::write(pipe.in, bytes.data(), sent), static_cast<ssize_t>(sent));
    ::close(pipe.in);
    return settled(loading);
  };
  const LoadState whole = send(bytes.size(), bytes.size(), 1 << 30);
  EXPECT_EQ(whole.phase, LoadPhase::ready) << whole.error;
  EXPECT_EQ(whole.bytes, bytes.size());
  EXPECT_EQ(whole.estimate->splats, 1000U);
  // Whole projected_splats, and no header that would miss the others
  const LoadState cut = send(bytes.size(), 320, 1 << 30);
  EXPECT_EQ(cut.phase, LoadPhase::failed);
  EXPECT_THAT(cut.error, HasSubstr("garden.splat: read: ended after 320 of 32000 bytes"));
  const LoadState large = send(2'000'000'000, 320, 1 << 20);
  EXPECT_THAT(large.error, HasSubstr("memory: needs about 2000.0 MB"));
  EXPECT_EQ(large.problem, "memory");
}

// A million splats are announced, of which a part has come.
TEST(SceneLoading, SaysWhatItWillTakeWhileItIsRead) {
  const auto header = [] {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 1000000\n";
    for (const char* name : {"x", "y", "z", "opacity", "scale_0", "scale_1", "scale_2", "rot_0",
                             "rot_1", "rot_2", "rot_3", "f_dc_0", "f_dc_1", "f_dc_2"})
      text += std::string("property float ") + name + "\n";
    text += "end_header\n";
    text.resize(100'000);
    return text;
  }();
  std::signal(SIGPIPE, SIG_IGN);
  Pipe pipe;
  SceneLoading loading;
  loading.begin(pipe.out, "large.ply", {});
  // Pipes hold 64 KB
  std::thread writer([&] {
    for (std::size_t done = 0; done < header.size();) {
      const auto put = ::write(pipe.in, header.data() + done, header.size() - done);
      ASSERT_GT(put, 0);
      done += static_cast<std::size_t>(put);
    }
  });
  for (int i = 0; i < 500 && !loading.state().estimate; ++i) std::this_thread::sleep_for(10ms);
  writer.join();
  const LoadState state = loading.state();
  EXPECT_EQ(state.phase, LoadPhase::reading);
  ASSERT_TRUE(state.estimate);
  EXPECT_EQ(state.estimate->splats, 1'000'000U);
  loading.cancel();
  ::close(pipe.in);

  Pipe again;
  loading.begin(again.out, "large.ply", {.memory = 10'000'000});
  ASSERT_GT(::write(again.in, header.data(), 60'000), 0);
  std::thread second([&] { ASSERT_GT(::write(again.in, header.data(), 40'000), 0); });
  const LoadState refused = settled(loading);
  second.join();
  ::close(again.in);
  EXPECT_EQ(refused.phase, LoadPhase::failed);
  EXPECT_THAT(refused.error, HasSubstr("large.ply: memory: needs about"));
}

TEST(SceneLoading, GivesUpAProviderThatStalls) {
  SceneLoading loading;
  Pipe pipe;
  ASSERT_EQ(::write(pipe.in, "glTF", 4), 4);
  loading.begin(pipe.out, "cloud.glb", {.patience = 0.3});
  const LoadState state = settled(loading);
  EXPECT_EQ(state.phase, LoadPhase::failed);
  EXPECT_THAT(state.error, HasSubstr("cloud.glb: read: nothing came"));
  ::close(pipe.in);
}

TEST(SceneLoading, CancelDoesNotWaitForAProvider) {
  SceneLoading loading;
  Pipe pipe;
  loading.begin(pipe.out, "cloud.glb", {});
  const auto start = std::chrono::steady_clock::now();
  loading.cancel();
  EXPECT_LT(std::chrono::steady_clock::now() - start, 50ms);
  EXPECT_EQ(loading.state().phase, LoadPhase::idle);
  for (int i = 0; i < 100 && is_open(pipe.out); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_FALSE(is_open(pipe.out)) << "the thread ends by itself";
  ::close(pipe.in);
}

TEST(SceneLoading, RefusesKindlyWhatIsTooLarge) {
  SceneLoading loading;
  const int descriptor = file_of(scene_bytes());
  ASSERT_EQ(::ftruncate(descriptor, off_t{2} << 30), 0);  // 2 GB, of which nothing is read
  loading.begin(descriptor, "huge.ply", {.memory = 1'000'000'000});
  LoadState state = settled(loading);
  EXPECT_EQ(state.phase, LoadPhase::failed);
  EXPECT_EQ(state.error, "huge.ply: memory: needs about 2147.5 MB, but only 1000.0 MB may be used");
  EXPECT_EQ(state.read, 0U);

  const auto bytes = scene_bytes();
  loading.begin(file_of(bytes), "tight.glb", {.memory = bytes.size() + 1000});
  state = settled(loading);
  EXPECT_EQ(state.phase, LoadPhase::failed) << "the file fits, what it decodes to does not";
  EXPECT_THAT(state.error, HasSubstr("tight.glb: memory: needs about"));

  std::signal(SIGPIPE, SIG_IGN);
  Pipe pipe;  // without an end, and without a size
  loading.begin(pipe.out, "endless", {.memory = 5'000'000});
  std::thread writer([&] {
    std::vector<std::byte> splats(1 << 16);  // of a .splat: unit quaternions
    for (std::size_t i = 0; i < splats.size(); i += 32)
      std::fill_n(&splats[i + 29], 3, std::byte{128}), splats[i + 28] = std::byte{255};
    while (::write(pipe.in, splats.data(), splats.size()) > 0) {
    }
  });
  state = settled(loading);
  EXPECT_EQ(state.phase, LoadPhase::failed);
  EXPECT_THAT(state.error, HasSubstr("endless: memory"));
  loading.cancel();
  writer.join();  // its pipe is closed
  ::close(pipe.in);
}

// A file of which only a window is in memory.
TEST(SceneLoading, AFileMayBeLargerThanTheMemory) {
  constexpr std::size_t kSplats = 50'000;
  const auto bytes = *encode_ply(test::random_cloud(kSplats, 3), "scene");
  const std::uint64_t memory = 56 * kSplats;  // a fifth of the file
  SceneLoading loading;
  loading.begin(file_of(bytes), "large.ply", {.memory = memory});
  const LoadState state = settled(loading);
  ASSERT_EQ(state.phase, LoadPhase::ready) << state.error;
  EXPECT_EQ(state.read, bytes.size());
  EXPECT_EQ(state.bytes, bytes.size());
  EXPECT_EQ(state.estimate->splats, kSplats);
  EXPECT_LE(state.estimate->decoded, memory);
  const auto scene = loading.take();
  EXPECT_EQ(scene->cloud.file_splats, kSplats);
  EXPECT_EQ(scene->cloud.file_sh_degree, 3);
  EXPECT_EQ(scene->cloud.sh_degree, 1);
  EXPECT_GT(scene->cloud.size(), kSplats / 2);
  EXPECT_LE(render::render_cloud_bytes(1) * scene->cloud.size(), memory);
}

TEST(SceneLoading, AFileThatIsCutWhileItIsReadIsAnError) {
  const auto bytes = *encode_ply(test::random_cloud(200'000, 3), "scene");
  const int descriptor = file_of(bytes), other = ::dup(descriptor);
  SceneLoading loading;
  loading.begin(descriptor, "cut.ply", {});
  while (loading.state().read == 0 && loading.state().phase == LoadPhase::reading)
    std::this_thread::yield();
  ASSERT_EQ(::ftruncate(other, 1000), 0);
  const LoadState state = settled(loading);
  ::close(other);
  ASSERT_EQ(state.phase, LoadPhase::failed);
  EXPECT_THAT(state.error, HasSubstr("cut.ply: read: ended after"));
  EXPECT_THAT(state.error, HasSubstr("it was cut, or is gone"));
}

TEST(SceneLoading, WhatIsNoSceneIsNotReadToItsEnd) {
  SceneLoading loading;
  const int descriptor = file_of(std::vector<std::byte>(1 << 20));
  ASSERT_EQ(::ftruncate(descriptor, off_t{1} << 30), 0);
  loading.begin(descriptor, "film.mp4", {.memory = std::size_t{4} << 30});
  const LoadState state = settled(loading);
  EXPECT_EQ(state.phase, LoadPhase::failed);
  EXPECT_THAT(state.error, HasSubstr("begins with zeros"));
  EXPECT_LT(state.read, std::size_t{4} << 20);
}

TEST(SceneLoading, SaysWhatIsWrongWithOtherFiles) {
  SceneLoading loading;
  const auto error_of = [&](int descriptor) {
    loading.begin(descriptor, "file", {});
    const LoadState state = settled(loading);
    EXPECT_EQ(state.phase, LoadPhase::failed);
    return state.error;
  };
  EXPECT_THAT(error_of(file_of({})), HasSubstr("file: the file is empty"));
  EXPECT_THAT(error_of(file_of(std::vector<std::byte>(1000))), HasSubstr("begins with zeros"));
  auto cut = scene_bytes();
  cut.resize(cut.size() / 2);
  EXPECT_FALSE(error_of(file_of(cut)).empty());
  EXPECT_THAT(error_of(::open("/tmp", O_RDONLY)), HasSubstr("is a folder"));
  EXPECT_FALSE(error_of(-1).empty());
  EXPECT_THAT(error_of(file_of(*encode_glb({}, "empty"))), HasSubstr("the scene is empty"));
}

}  // namespace
}  // namespace fluxgs::viewer
