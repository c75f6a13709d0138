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

FLUXGS_GL_TEST_SUITE(ResizeTest);

}  // namespace
}  // namespace fluxgs::test
