// Images that are blended front to back, in slices with marks between them.
#include <gmock/gmock.h>

#include "image_fixture.h"

namespace fluxgs::test {
namespace {

using render::Accumulation;
using render::Renderer;
using render::RenderTarget;
using render::TargetFormat;

class SlicesTest : public ImageTest {
 protected:
  void SetUp() override {
    ImageTest::SetUp();
    if (!IsSkipped() && !api().capabilities.framebuffer_fetch)
      GTEST_SKIP() << "the driver has no framebuffer fetch";
  }

  std::unique_ptr<Renderer> with_slices(int slices) {
    return must(Renderer::create(api(), {.slices = slices}));
  }

  Image<float> draw_marked(Renderer& with, const Camera& camera, bool marks = true) {
    const RenderTarget target = must(RenderTarget::create(
        api(), camera.width, camera.height, TargetFormat::rgba16f, accurate(), 1, marks));
    must(with.draw(camera, kRose, target));
    return must(with.read(target));
  }
};

TEST_P(SlicesTest, AreAsExactAsBackToFront) {
  for (const int count : {1, 100, 128, 129, 5000}) {
    const SplatCloud cloud = random_cloud(static_cast<std::size_t>(count), 1, 2);
    const Camera camera = orbit_camera(200, 151, {}, 2, 1, 4);
    const ReferenceImage reference = render_reference(cloud, camera, kRose);
    for (const int slices : {2, 7, render::kMostSlices}) {
      const auto with = with_slices(slices);
      must(with->upload(cloud));
      for (const bool marks : {false, true}) {
        const Image<float> image = draw_marked(*with, camera, marks);
        const Difference d = compare(image, reference, false);
        const std::string label = std::to_string(count) + " splats, " + std::to_string(slices) +
                                  " slices" + (marks ? ", marks" : "");
        print(label, d);
        EXPECT_GE(d.psnr, 65) << label;
        EXPECT_LE(d.greatest, 2.25 / 255) << label;
        keep_image(label, image);
      }
    }
  }
}

// A wall hides the splats behind it, within the error that marks may have.
TEST_P(SlicesTest, SkipWhatCannotBeSeen) {
  SplatCloud cloud;
  for (int i = 0; i < 1000; ++i) {
    const float depth = static_cast<float>(i) / 1000;
    const glm::vec3 color = i < 500 ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1);
    add(cloud, {.position = {0, 0, depth}, .scale = glm::vec3(1), .opacity = 0.9F, .color = color});
  }
  const Camera camera = front_camera(64, 48, 1.5);
  const auto with = with_slices(8);
  must(with->upload(cloud));
  const Image<float> image = draw_marked(*with, camera);
  EXPECT_NEAR(image.at(32, 24)[0], 1, 1.0 / 255);
  EXPECT_NEAR(image.at(32, 24)[2], 0, 1.0 / 255);
  EXPECT_NEAR(image.at(32, 24)[3], 1, 1.0 / 255);
}

TEST_P(SlicesTest, NoSplatsLeaveTheBackground) {
  const auto with = with_slices(4);
  must(with->upload(SplatCloud()));
  const Image<float> image = draw_marked(*with, front_camera(8, 8, 1));
  EXPECT_NEAR(image.at(4, 4)[0], 0.9, 0.001);
  EXPECT_EQ(image.at(4, 4)[3], 0);
}

// Without framebuffer fetch, or with too few storage buffers, the image is drawn back to front.
TEST_P(SlicesTest, AreLeftOutWhereTheDriverLacksThem) {
  const gl::Capabilities before = api().capabilities;
  EXPECT_EQ(with_slices(8)->settings().slices, 8);
  api().capabilities.framebuffer_fetch = false;
  EXPECT_EQ(with_slices(8)->settings().slices, 1);
  api().capabilities = before;
  api().capabilities.max_vertex_storage_blocks = 2;
  EXPECT_EQ(with_slices(8)->settings().slices, 1);
  api().capabilities = before;
  for (const int wrong : {0, -1, 65}) {
    const auto refused = Renderer::create(api(), {.slices = wrong});
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message(), testing::HasSubstr("slices"));
  }
}

FLUXGS_GL_TEST_SUITE(SlicesTest);

}  // namespace
}  // namespace fluxgs::test
