// What the renderer asks the driver for: as much as was estimated, and nothing in a frame.
#include <gtest/gtest.h>

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

// Stands between the renderer and the driver and adds up what is allocated. One at a time.
struct Ledger {
  std::size_t bytes = 0;
  int allocations = 0;

  void add(std::size_t more) {
    bytes += more;
    ++allocations;
  }
};
Ledger ledger;
decltype(gl::Api::BufferData) driver_buffer_data = nullptr;
decltype(gl::Api::TexStorage2D) driver_tex_storage = nullptr;

void GL_APIENTRY count_buffer(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
  ledger.add(static_cast<std::size_t>(size));
  driver_buffer_data(target, size, data, usage);
}

std::size_t texel_bytes(GLenum format) {
  switch (format) {
    case GL_RGBA32F:
    case GL_RGBA32UI:
      return 16;
    case GL_RGBA16F:
      return 8;
    default:
      return 4;
  }
}

void GL_APIENTRY count_texture(GLenum target, GLsizei levels, GLenum format, GLsizei width,
                               GLsizei height) {
  ledger.add(texel_bytes(format) * static_cast<std::size_t>(width) *
             static_cast<std::size_t>(height));
  driver_tex_storage(target, levels, format, width, height);
}

class MemoryTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    ledger = {};
    driver_buffer_data = std::exchange(api().BufferData, count_buffer);
    driver_tex_storage = std::exchange(api().TexStorage2D, count_texture);
  }
  void TearDown() override {
    if (!IsSkipped()) {
      api().BufferData = driver_buffer_data;
      api().TexStorage2D = driver_tex_storage;
    }
    GlTest::TearDown();
  }

  // What upload() of a cloud and a target take, beyond what an empty renderer does for its scene.
  void expect_as_estimated(const std::string& label, std::size_t count, int degree,
                           const RendererSettings& settings, const render::TargetPlan& plan) {
    ledger = {};
    const auto made = must(render::Renderer::create(api(), settings));
    const std::size_t with_empty_sorter = ledger.bytes;
    const auto target = must(RenderTarget::create(api(), plan.width, plan.height, plan.format,
                                                  plan.accumulation, plan.scale));
    must(made->upload(random_cloud(count, degree, 1)));
    const auto estimate = render::estimate_memory(count, degree, made->settings(), plan);
    // The buffers of a sorter without a scene were replaced
    constexpr std::size_t kKept = 20 + sizeof(render::FrameUniforms);
    const std::size_t kept = kKept + std::size_t{12} * static_cast<std::size_t>(settings.batch);
    EXPECT_EQ(ledger.bytes - (with_empty_sorter - kept), estimate.total()) << label;
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

// The GPU's side of "nothing is allocated in the steady state", over every sorter.
TEST_P(MemoryTest, FramesAllocateNothing) {
  for (const SorterKind kind : {SorterKind::gpu_radix, SorterKind::cpu_async, SorterKind::exact}) {
    const auto made = must(render::Renderer::create(api(), {.sorter = kind}));
    must(made->upload(random_cloud(500, 1, 2)));
    const auto target = must(RenderTarget::create(api(), 32, 24, TargetFormat::rgba8));
    must(made->draw(orbit_camera(32, 24, {}, 2, 0, 50), {}, target));
    ledger = {};
    for (int i = 0; i < 50; ++i) must(made->draw(orbit_camera(32, 24, {}, 2, i, 50), {}, target));
    EXPECT_EQ(ledger.allocations, 0);
  }
}

FLUXGS_GL_TEST_SUITE(MemoryTest);

}  // namespace
}  // namespace fluxgs::test
