// What the renderer asks the driver for: as much as was estimated.
#include <gtest/gtest.h>

#include "gl_faults.h"
#include "gl_fixture.h"
#include "render/memory_estimate.h"
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
    const GlFaults between(api());
    const auto made = must(render::Renderer::create(api(), settings));
    const auto target = must(RenderTarget::create(api(), plan.width, plan.height, plan.format,
                                                  plan.accumulation, plan.scale));
    must(made->upload(random_cloud(count, degree, 1)));
    const auto estimate = render::estimate_memory(count, degree, made->settings(), plan);
    EXPECT_EQ(faults.used, estimate.total()) << label;
  }
};

TEST_P(MemoryTest, IsAsEstimated) {
  const render::TargetPlan plain{.width = 64, .height = 48};
  for (const std::size_t count : {0, 1, 2047, 5000})
    for (const int degree : {0, 1, 3})
      expect_as_estimated(std::to_string(count) + " of degree " + std::to_string(degree), count,
                          degree, {}, plain);
  expect_as_estimated("CPU", 3000, 1, {.sorter = SorterKind::cpu_async}, plain);
  expect_as_estimated("exact", 3000, 1, {.sorter = SorterKind::exact}, plain);
  expect_as_estimated("half", 3000, 1, {.record = render::RecordPrecision::half}, plain);
  expect_as_estimated("textures", 3000, 1, {.texture_fetch = true}, plain);
  expect_as_estimated("4 bits, batches of 7", 3000, 1, {.batch = 7, .sort_digit_bits = 4}, plain);
  if (!api().capabilities.half_float_targets) return;
  expect_as_estimated("halves", 10, 0, {},
                      {.width = 65, .height = 33, .accumulation = Accumulation::half_float});
  expect_as_estimated("a smaller picture", 10, 0, {},
                      {.width = 65, .height = 33, .format = TargetFormat::rgba16f, .scale = 0.5});
  if (!api().capabilities.float_targets) return;
  expect_as_estimated("floats", 10, 0, {},
                      {.width = 65, .height = 33, .accumulation = Accumulation::single_float});
}

TEST_P(MemoryTest, ABudgetIsFilledButNotExceeded) {
  const render::TargetPlan plan{.width = 1280, .height = 720};
  for (const std::size_t budget : {0UL, 1'000'000UL, 10'000'000UL, 500'000'000UL}) {
    const std::uint64_t count = render::splats_that_fit(budget, 1, {}, plan);
    if (count > 0) {
      EXPECT_LE(render::estimate_memory(count, 1, {}, plan).total(), budget);
    }
    EXPECT_GT(render::estimate_memory(count + 1, 1, {}, plan).total(), budget);
  }
}

FLUXGS_GL_TEST_SUITE(MemoryTest);

}  // namespace
}  // namespace fluxgs::test
