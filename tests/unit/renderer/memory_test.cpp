// What the renderer asks the driver for: as much as was estimated.
#include <gtest/gtest.h>

#include "gl_faults.h"
#include "gl_fixture.h"
#include "render/memory_estimate.h"
#include "render/scene_buffers.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

using render::Accumulation;
using render::RendererSettings;
using render::RenderTarget;
using render::SorterKind;
using render::TargetFormat;

class MemoryTest : public GlTest {
 protected:
  // What a renderer with a cloud and a target hold.
  void expect_as_estimated(const std::string& label, std::size_t count, int degree,
                           const RendererSettings& settings, const render::TargetPlan& plan) {
    expect_as_estimated(label, random_cloud(count, degree, 1), settings, plan);
  }
  void expect_as_estimated(const std::string& label, const SplatCloud& cloud,
                           const RendererSettings& settings, const render::TargetPlan& plan) {
    const GlFaults between(api());
    const auto made = must(render::Renderer::create(api(), settings));
    const auto target = must(RenderTarget::create(api(), plan.width, plan.height, plan.format,
                                                  plan.accumulation, plan.scale, plan.marks));
    must(made->upload(cloud));
    const auto estimate = render::estimate_memory(count_degrees(cloud), made->settings(), plan);
    EXPECT_EQ(faults.used, estimate.total()) << label;
  }
};

TEST_P(MemoryTest, IsAsEstimated) {
  const render::TargetPlan plain{.width = 64, .height = 48};
  for (const std::size_t count : {0, 1, 2047, 5000})
    for (const int degree : {0, 1, 3})
      expect_as_estimated(std::to_string(count) + " of degree " + std::to_string(degree), count,
                          degree, {}, plain);
  SplatCloud mixed = mixed_cloud(3000, 2);
  expect_as_estimated("mixed degrees", mixed, {}, plain);
  mixed.positions[5].x = std::nanf("");  // not drawn, but it keeps its place
  mixed.sh_rest[100].x = std::nanf("");
  expect_as_estimated("undrawable ones", mixed, {}, plain);
  expect_as_estimated("CPU", 3000, 1, {.sorter = SorterKind::cpu_async}, plain);
  expect_as_estimated("exact", 3000, 1, {.sorter = SorterKind::exact}, plain);
  expect_as_estimated("half", 3000, 1, {.splat_precision = render::SplatPrecision::half}, plain);
  expect_as_estimated("textures", 3000, 1, {.texture_fetch = true}, plain);
  for (const std::size_t count : {0, 1, 2047, 5000})
    expect_as_estimated("without compute shaders", count, 3, {.compute = false}, plain);
  expect_as_estimated("half, without compute shaders", 3000, 1,
                      {.sorter = SorterKind::exact,
                       .splat_precision = render::SplatPrecision::half,
                       .compute = false},
                      plain);
  expect_as_estimated("4 bits, batches of 7", 3000, 1, {.batch = 7, .sort_digit_bits = 4}, plain);
  expect_as_estimated("marks", 3000, 1, {.slices = 8}, {.width = 65, .height = 33, .marks = true});
  if (!api().capabilities.half_float_targets) return;
  expect_as_estimated("halves", 10, 0, {},
                      {.width = 65, .height = 33, .accumulation = Accumulation::half_float});
  expect_as_estimated("a smaller image", 10, 0, {},
                      {.width = 65, .height = 33, .format = TargetFormat::rgba16f, .scale = 0.5});
  if (!api().capabilities.float_targets) return;
  expect_as_estimated("floats", 10, 0, {},
                      {.width = 65, .height = 33, .accumulation = Accumulation::single_float});
}

TEST_P(MemoryTest, ABudgetIsFilledButNotExceeded) {
  const render::TargetPlan plan{.width = 1280, .height = 720};
  for (const std::size_t budget : {0UL, 1'000'000UL, 10'000'000UL, 500'000'000UL}) {
    const auto fit = [&](const DegreeCounts& scene) {
      return render::splats_that_fit(budget, scene, {}, plan);
    };
    const auto estimate = [&](const DegreeCounts& splats) {
      return render::estimate_memory(splats, {}, plan).total();
    };
    const std::uint64_t count = fit({0, 100'000'000, 0, 0});
    if (count > 0) {
      EXPECT_LE(estimate({0, count, 0, 0}), budget);
    }
    EXPECT_GT(estimate({0, count + 1, 0, 0}), budget);
    EXPECT_GE(fit({50'000'000, 50'000'000, 0, 0}), count);
    EXPECT_LE(fit({0, 100'000'000 - count, 0, count}), count);
  }
  EXPECT_EQ(render::splats_that_fit(500'000'000, {1, 2, 3, 4}, {}, plan), 10U);
}

// Whichever splats stay when some must go, they take no more than was reckoned with.
TEST(LargestOf, TakesHighDegreesFirst) {
  const DegreeCounts scene{10, 20, 30, 40};
  EXPECT_EQ(render::largest_of(scene, 0), (DegreeCounts{}));
  EXPECT_EQ(render::largest_of(scene, 40), (DegreeCounts{0, 0, 0, 40}));
  EXPECT_EQ(render::largest_of(scene, 75), (DegreeCounts{0, 5, 30, 40}));
  EXPECT_EQ(render::largest_of(scene, 1000), scene);
  EXPECT_EQ(render::sh_bytes(scene), 20U * 24 + 30 * 48 + 40 * 96);
}

TEST(MostSplats, FitIntoTheDriversBlocks) {
  gl::Capabilities driver;
  driver.max_work_groups_x = 65535;
  const auto most = [&](std::int64_t block, const DegreeCounts& scene) {
    driver.max_storage_block_bytes = block;
    return render::max_splats(driver, scene);
  };
  EXPECT_EQ(most(1 << 20, {10, 20, 30, 40}), 100U);
  EXPECT_EQ(most(6400, {1000, 0, 0, 0}), 100U);  // 64 bytes of geometry
  EXPECT_EQ(most(6400, {0, 1000, 0, 0}), 100U);  // more than the 24 of SH coefficients
  EXPECT_EQ(most(6400, {0, 0, 1000, 0}), 100U);  // 48
  EXPECT_EQ(most(9600, {0, 0, 0, 1000}), 100U);  // 96
  EXPECT_EQ(most(96 * 140 + 48 * 3 + 47, {1000, 0, 130, 140}), 143U);
  EXPECT_EQ(most(96 * 140 + 48 * 130, {1000, 0, 130, 140}), 307U);  // of all 19,680 bytes
  EXPECT_EQ(most(std::int64_t{1} << 40, {100'000'000, 0, 0, 0}), 65535U * 128 - 1);
}

FLUXGS_GL_TEST_SUITE(MemoryTest);

}  // namespace
}  // namespace fluxgs::test
