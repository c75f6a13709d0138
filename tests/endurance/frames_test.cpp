// Thousands of frames: nothing is allocated, nothing goes wrong and no memory is lost.
#include <gtest/gtest.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>

#include "allocations.h"
#include "render/scene_view.h"
#include "unit/renderer/gl_faults.h"
#include "unit/renderer/gl_fixture.h"
#include "unit/renderer/scenes.h"

namespace fluxgs::test {
namespace {

// SwiftShader's pools reach their size after some 2,000 frames
constexpr int kWarmUp = kSanitized ? 100 : 2500;
constexpr std::size_t kStretches = 5;
constexpr int kInFlight = 3;  // frames, as a window's swap chain has them
constexpr int kWidth = 32, kHeight = 24;

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

struct Growth {
  long news = 0, gl_allocations = 0;
  long heap = 0, resident = 0, gl = 0;  ///< bytes
};

class FramesTest : public GlTest {
 protected:
  // A camera on an orbit that ends where it starts.
  void draw(render::SceneView& view, int i) {
    must(view.draw(orbit_camera(kWidth, kHeight, {}, 2, i % 360, 360), {}));
  }

  /// SwiftShader takes ten times as long a frame, and its memory is measured less exactly.
  static int frames() {
    if (kSanitized) return 500;
    return GetParam() == host::HostGl::angle ? 2000 : 10'000;
  }

  Growth grown_over(render::SceneView& view, int frames) {
    const auto heap = [] { return static_cast<long>(::mallinfo2().uordblks); };
    const auto resident = [] { return static_cast<long>(resident_bytes()); };
    Growth before{0, faults.allocations, heap(), resident(), static_cast<long>(faults.used)};
    before.news = allocations.count;  // Reading the others takes some
    for (int i = 0; i < frames; ++i) {
      draw(view, i);
      if (i % kInFlight == 0) api().Finish();
      if (i % 100 == 0) {
        EXPECT_EQ(api().GetError(), GLenum{GL_NO_ERROR}) << "frame " << i;
      }
    }
    api().Finish();
    const long made = allocations.count - before.news;
    return {made, faults.allocations - before.gl_allocations, heap() - before.heap,
            resident() - before.resident, static_cast<long>(faults.used) - before.gl};
  }

  /// Over all frames. Of the process's memory the median stretch stands for all: what leaks does so
  /// in each, while drivers take and return pools at times, the more the busier the machine.
  Growth steady_growth(render::SceneView& view) {
    Growth all;
    std::array<long, kStretches> heap, resident;
    for (std::size_t k = 0; k < kStretches; ++k) {
      const Growth g = grown_over(view, frames() / static_cast<int>(kStretches));
      all.news += g.news, all.gl_allocations += g.gl_allocations, all.gl += g.gl;
      heap[k] = g.heap, resident[k] = g.resident;
    }
    const auto median = [](std::array<long, kStretches> values) {
      std::ranges::nth_element(values, values.begin() + kStretches / 2);
      return values[kStretches / 2];
    };
    all.heap = static_cast<long>(kStretches) * median(heap);
    all.resident = static_cast<long>(kStretches) * median(resident);
    return all;
  }

  void expect_steady(const char* name, const render::SceneViewSettings& settings);
};

void FramesTest::expect_steady(const char* name, const render::SceneViewSettings& settings) {
  const GlFaults between(api());
  render::SceneView view(std::make_shared<render::RenderCloud>(random_cloud(300, 1, 31)), settings);
  must(view.open(device(), kWidth, kHeight));
  static_cast<void>(grown_over(view, kWarmUp));
  view.renderer().wait_for_sorts(true);
  draw(view, 0);
  const Image<std::uint8_t> first = must(view.read());
  view.renderer().wait_for_sorts(false);
  const auto start = std::chrono::steady_clock::now();
  const Growth growth = steady_growth(view);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf(
      "%-7s %-9s %d frames, %.2f ms each: %ld allocations (CPU), %ld (GPU); bytes grown: "
      "heap %ld, resident %ld, GPU %ld\n",
      std::string(host::name(GetParam())).c_str(), name, frames(), 1e3 * seconds / frames(),
      growth.news, growth.gl_allocations, growth.heap, growth.resident, growth.gl);
  EXPECT_EQ(growth.news, 0);
  EXPECT_EQ(growth.gl_allocations, 0);
  EXPECT_EQ(growth.gl, 0);
  // SwiftShader takes memory in steps of 32 MB, of which it uses little; AddressSanitizer keeps
  // what was freed
  if (GetParam() != host::HostGl::angle && !kSanitized) {
    EXPECT_LT(growth.heap, 10'000);
  }
  // Its scheduler's stacks, too, grow with the number of tasks that wait for a busy processor
  if (!kSanitized) {
    EXPECT_LT(growth.resident, GetParam() == host::HostGl::angle ? 10'000'000 : 2'000'000);
  }
  EXPECT_TRUE(api().debug.mistakes().empty());
  view.renderer().wait_for_sorts(true);
  draw(view, 0);
  EXPECT_EQ(must(view.read()).pixels, first.pixels);
}

TEST_P(FramesTest, SortedByTheGpu) { expect_steady("gpu_radix", {}); }
TEST_P(FramesTest, SortedByAThread) {
  expect_steady("cpu_async", {.renderer = {.sorter = render::SorterKind::cpu_async}});
}

FLUXGS_GL_TEST_SUITE(FramesTest);

}  // namespace
}  // namespace fluxgs::test
