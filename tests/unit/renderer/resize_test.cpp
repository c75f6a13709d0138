// A surface whose size changes in every frame, as while a window is dragged at its corner or a
// phone is turned.
#include "gl_faults.h"
#include "image_fixture.h"
#include "render/memory_estimate.h"

namespace fluxgs::test {
namespace {

using render::TargetPlan;

class ResizeTest : public ImageTest {
 protected:
  // Of frame `i`: every format and way of blending there is, now and then a smaller image.
  TargetPlan plan(int i) {
    const bool half = api().capabilities.half_float_targets;
    return {.width = 9 + i * 37 % 151,
            .height = 7 + i * 53 % 97,
            .format = half && i % 3 == 0 ? TargetFormat::rgba16f : TargetFormat::rgba8,
            .accumulation = i % 2 == 0 ? accurate() : Accumulation::direct,
            .scale = i % 5 == 0 ? 0.5 : 1};
  }
  RenderTarget target(const TargetPlan& p) {
    return must(RenderTarget::create(api(), p.width, p.height, p.format, p.accumulation, p.scale));
  }
};

TEST_P(ResizeTest, TwoHundredFramesLeaveNothingBehind) {
  constexpr int kFrames = 200;
  const SplatCloud cloud = random_cloud(1000, 1, 31);
  const auto camera = [](const TargetPlan& p, int i) {
    return orbit_camera(p.width, p.height, {}, 2, i, kFrames);
  };
  must(renderer().upload(cloud));
  Image<float> last;
  {
    const GlFaults counted(api());
    RenderTarget shown;
    for (int i = 0; i < kFrames; ++i) {
      const TargetPlan p = plan(i);
      shown = target(p);
      must(renderer().draw(camera(p, i), kRose, shown));
      ASSERT_EQ(api().GetError(), GLenum{GL_NO_ERROR}) << "frame " << i;
      // Of the renderer nothing, of targets one
      const std::size_t textures = shown.needs_resolve() ? 2 : 1;
      ASSERT_EQ(faults.textures.size(), textures) << "frame " << i;
      ASSERT_EQ(faults.framebuffers, static_cast<long>(textures)) << "frame " << i;
      ASSERT_EQ(faults.used, render::estimate_memory({}, {}, p).targets) << "frame " << i;
    }
    last = must(renderer().read(shown));
    shown = {};
    EXPECT_EQ(faults.used, 0U);
    EXPECT_EQ(faults.framebuffers, 0);
    // And none wrote over what the one before might still be drawn from
    EXPECT_EQ(faults.draws, kFrames);
    EXPECT_EQ(faults.overwritten, 0);
  }
  const auto fresh = must(render::Renderer::create(api()));
  must(fresh->upload(cloud));
  const TargetPlan p = plan(kFrames - 1);
  const RenderTarget same = target(p);
  must(fresh->draw(camera(p, kFrames - 1), kRose, same));
  EXPECT_EQ(last.pixels, must(fresh->read(same)).pixels);
}

// What a window gets: one allocation for every scale, the same pixels as a target of that scale.
TEST_P(ResizeTest, AWindowsTargetHasRoomForEveryScale) {
  const Camera camera = orbit_camera(300, 270, {}, 2, 1, 4);
  must(renderer().upload(random_cloud(2000, 1, 32)));
  for (const Accumulation way : {accurate(), Accumulation::direct}) {
    RenderTarget window = must(RenderTarget::create_for_window(api(), 300, 270, way));
    for (const double scale : {1.0, 0.5, 0.37, 0.004, 1.0}) {
      const RenderTarget other =
          must(RenderTarget::create(api(), 300, 270, TargetFormat::rgba8, way, scale));
      must(renderer().draw(camera, kRose, other));
      const Image<std::uint8_t> expected = must(render::read_image(api(), other));
      window.set_scale(scale);
      must(renderer().draw(camera, kRose, window));
      EXPECT_EQ(must(renderer().read_shown(window)).pixels, expected.pixels) << scale;
    }
    // Reduced images are rounded and limited once less
    const auto reduced = must(renderer().read_shown(window, 70));
    const RenderTarget other =
        must(RenderTarget::create(api(), 300, 270, TargetFormat::rgba8, way));
    must(renderer().draw(camera, kRose, other));
    const auto expected = must(render::read_image(api(), other, 70));
    ASSERT_EQ(reduced.width, 70);
    ASSERT_EQ(reduced.pixels.size(), expected.pixels.size());
    double square_error = 0;
    for (std::size_t i = 0; i < expected.pixels.size(); ++i)
      square_error += std::pow(reduced.pixels[i] - expected.pixels[i], 2);
    EXPECT_LT(square_error / static_cast<double>(expected.pixels.size()), 1);
  }
}

TEST_P(ResizeTest, ScalesAllocateNothing) {
  const Camera camera = orbit_camera(64, 48, {}, 2, 1, 4);
  must(renderer().upload(random_cloud(500, 1, 33)));
  const GlFaults counted(api());
  RenderTarget window = must(RenderTarget::create_for_window(api(), 64, 48, accurate()));
  const long before = faults.allocations;
  for (const double scale : {0.5, 0.85, 1.0, 0.3}) {
    window.set_scale(scale);
    must(renderer().draw(camera, kRose, window));
  }
  EXPECT_EQ(faults.allocations, before);
  EXPECT_EQ(faults.used,
            render::estimate_memory(
                {}, {}, {.width = 64, .height = 48, .accumulation = accurate(), .for_window = true})
                .targets);
}

FLUXGS_GL_TEST_SUITE(ResizeTest);

}  // namespace
}  // namespace fluxgs::test
