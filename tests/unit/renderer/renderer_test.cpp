// The renderer's behaviour at the edges: what it refuses, what it repeats exactly, what it counts.
#include "render/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gl_fixture.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

using render::RenderTarget;
using render::TargetFormat;
using testing::HasSubstr;

class RendererTest : public GlTest {
 protected:
  RenderTarget target(int width, int height, TargetFormat format = TargetFormat::rgba16f) {
    return must(RenderTarget::create(api(), width, height, format));
  }
  Image<float> draw(render::Renderer& with, const Camera& camera,
                    const RenderOptions& options = {}) {
    const RenderTarget made = target(camera.width, camera.height);
    must(with.draw(camera, options, made));
    return must(with.read(made));
  }
};

TEST_P(RendererTest, AnEmptySceneIsTheBackground) {
  const auto fresh = must(render::Renderer::create(api()));
  const RenderOptions options{.background = {0.25, 0.5, 1.0}};
  for (int round = 0; round < 2; ++round) {  // Before any upload, and after an empty one
    const Image<float> image = draw(*fresh, front_camera(5, 3, 1), options);
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
      EXPECT_EQ(image.pixels[i], 0.25F);
      EXPECT_EQ(image.pixels[i + 1], 0.5F);
      EXPECT_EQ(image.pixels[i + 2], 1.0F);
      EXPECT_EQ(image.pixels[i + 3], 0.0F);
    }
    EXPECT_EQ(must(fresh->stats()).drawn, 0U);
    must(fresh->upload({}));
  }
}

// Each splat its own pixel: a splat lost or drawn twice at a work group's or batch's edge shows.
TEST_P(RendererTest, EveryCountDrawsEverySplat) {
  constexpr int kSide = 64;
  const Camera camera = front_camera(kSide, kSide, 1);
  for (const int count : {1, 2, 127, 128, 129, 255, 256, 257, 2047, 2048, 2049, 4096}) {
    SplatCloud cloud;
    for (int i = 0; i < count; ++i) {
      const int column = i % kSide, row = i / kSide;
      const float x = (static_cast<float>(column) + 0.5F) / kSide - 0.5F;
      const float y = (static_cast<float>(row) + 0.5F) / kSide - 0.5F;
      add(cloud, {.position = {x, y, 0}, .scale = glm::vec3(1e-6F), .color = {1, 1, 1}});
    }
    must(renderer().upload(cloud));
    // So little dilation that a splat is gone at its neighbour's centre.
    const Image<float> image = draw(renderer(), camera, {.filter = ScreenFilter{.dilation = 0.04}});
    for (int i = 0; i < kSide * kSide; ++i)
      ASSERT_NEAR(image.at(i % kSide, i / kSide)[0], i < count ? 0.8F : 0.0F, 1e-3F)
          << "splat " << i << " of " << count;
    EXPECT_EQ(must(renderer().stats()).drawn, static_cast<std::uint32_t>(count));
  }
}

TEST_P(RendererTest, TheSameImageAgainBitForBit) {
  must(renderer().upload(random_cloud(4000, 2, 1)));
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  const Image<float> first = draw(renderer(), camera);
  static_cast<void>(draw(renderer(), orbit_camera(90, 70, {}, 2, 2, 4)));
  EXPECT_EQ(draw(renderer(), camera).pixels, first.pixels);
}

TEST_P(RendererTest, BatchAndDigitWidthChangeNothing) {
  const SplatCloud cloud = random_cloud(3001, 1, 2);
  must(renderer().upload(cloud));
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  const Image<float> expected = draw(renderer(), camera);
  for (const render::RendererSettings& settings : {render::RendererSettings{.batch = 1},
                                                   {.batch = 3},
                                                   {.batch = 32},
                                                   {.batch = 64},
                                                   {.batch = 128, .sort_digit_bits = 4}}) {
    const auto other = must(render::Renderer::create(api(), settings));
    must(other->upload(cloud));
    EXPECT_EQ(draw(*other, camera).pixels, expected.pixels) << settings.batch;
  }
}

TEST_P(RendererTest, ScenesReplaceEachOther) {
  const Camera camera = orbit_camera(100, 80, {}, 2, 1, 4);
  const SplatCloud small = random_cloud(100, 3, 3), large = random_cloud(5000, 0, 4);
  must(renderer().upload(small));
  const Image<float> expected = draw(renderer(), camera);
  must(renderer().upload(large));
  EXPECT_NE(draw(renderer(), camera).pixels, expected.pixels);
  must(renderer().upload(small));
  EXPECT_EQ(draw(renderer(), camera).pixels, expected.pixels);
}

TEST_P(RendererTest, StatsCountAndTimeTheFrame) {
  SplatCloud cloud = random_cloud(1000, 0, 5);
  for (std::size_t i = 0; i < 400; ++i) cloud.positions[i].z = -50;
  for (std::size_t i = 400; i < 500; ++i) cloud.opacity_logits[i] = -10;
  for (std::size_t i = 500; i < 1000; ++i) cloud.opacity_logits[i] = 1;
  must(renderer().upload(cloud));
  static_cast<void>(draw(renderer(), front_camera(100, 100, 3)));
  const render::FrameStats stats = must(renderer().stats());
  EXPECT_EQ(stats.drawn, 500U);
  ASSERT_EQ(stats.stages.has_value(), api().capabilities.timestamps);
  if (!stats.stages) return;
  for (const double ms :
       {stats.stages->project, stats.stages->sort, stats.stages->draw, stats.stages->resolve}) {
    EXPECT_GE(ms, 0);
    EXPECT_LT(ms, 60'000);
  }
}

TEST_P(RendererTest, ScalesTheCameraToTheTarget) {
  must(renderer().upload(random_cloud(200, 1, 6)));
  const RenderTarget made = target(40, 20);
  must(renderer().draw(front_camera(40, 20, 2), {}, made));
  const Image<float> expected = must(renderer().read(made));
  Camera twice = front_camera(40, 20, 2);
  for (double* v : {&twice.fx, &twice.fy, &twice.cx, &twice.cy}) *v *= 2;
  twice.width = 80;
  twice.height = 40;
  must(renderer().draw(twice, {}, made));
  EXPECT_EQ(must(renderer().read(made)).pixels, expected.pixels);
}

TEST_P(RendererTest, RefusesWhatMakesNoImage) {
  must(renderer().upload(random_cloud(10, 0, 6)));
  const RenderTarget made = target(20, 10);
  const auto refusal = [&](auto change) {
    Camera camera = front_camera(20, 10, 2);
    RenderOptions options;
    change(camera, options);
    const auto drawn = renderer().draw(camera, options, made);
    return drawn ? std::string("was drawn") : drawn.error().message();
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([](Camera&, RenderOptions&) {}), "was drawn");
  const auto names = [&](const char* field, auto change) {
    EXPECT_THAT(refusal(change), HasSubstr(field));
  };
  names("size", [](Camera& c, RenderOptions&) { c.width = 0; });
  names("focal length", [](Camera& c, RenderOptions&) { c.fx = 0; });
  names("focal length", [](Camera& c, RenderOptions&) { c.fy = kNan; });
  names("principal point", [](Camera& c, RenderOptions&) { c.cx = kNan; });
  names("pose", [](Camera& c, RenderOptions&) { c.rotation[1][2] = kNan; });
  names("pose", [](Camera& c, RenderOptions&) { c.translation.z = INFINITY; });
  names("alpha_min", [](Camera&, RenderOptions& o) { o.alpha_min = 0; });
  names("alpha_max", [](Camera&, RenderOptions& o) { o.alpha_max = kNan; });
  names("dilation", [](Camera&, RenderOptions& o) { o.filter = ScreenFilter{.dilation = -1}; });
  names("near_plane", [](Camera&, RenderOptions& o) { o.near_plane = 0; });
  names("depth_spread_max", [](Camera&, RenderOptions& o) { o.depth_spread_max = -1; });
  names("frustum_margin", [](Camera&, RenderOptions& o) { o.frustum_margin = kNan; });
  names("sh_degree", [](Camera&, RenderOptions& o) { o.sh_degree = 4; });
  names("background", [](Camera&, RenderOptions& o) { o.background.g = kNan; });
  names("background", [](Camera&, RenderOptions& o) { o.background.b = 70'000; });  // as half: ∞
  names("background", [](Camera&, RenderOptions& o) { o.background.r = -0.1; });
}

TEST_P(RendererTest, RefusesCloudsThatDoNotFit) {
  SplatCloud torn = random_cloud(10, 1, 7);
  torn.rotations.pop_back();
  EXPECT_THAT(renderer().upload(torn).error().message(), HasSubstr("every splat"));
  SplatCloud degree = random_cloud(10, 1, 7);
  degree.sh_degree = 4;
  EXPECT_THAT(renderer().upload(degree).error().message(), HasSubstr("sh_degree"));

  // A driver with small buffers: the cloud is refused before anything is allocated, and the scene
  // that was there stays.
  must(renderer().upload(random_cloud(10, 0, 7)));
  const Camera camera = front_camera(20, 20, 2);
  const Image<float> before = draw(renderer(), camera);
  const auto limit = api().capabilities.max_storage_block_bytes;
  api().capabilities.max_storage_block_bytes = 1000;
  const auto refused = renderer().upload(random_cloud(16, 0, 8));
  api().capabilities.max_storage_block_bytes = limit;
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("it can hold 15"));
  EXPECT_EQ(draw(renderer(), camera).pixels, before.pixels);
}

TEST_P(RendererTest, RefusesTargetsAndSettingsThatCannotBe) {
  const auto refusal = [&](int width, int height) {
    const auto made = RenderTarget::create(api(), width, height, TargetFormat::rgba8);
    return made ? std::string("was made") : made.error().message();
  };
  EXPECT_THAT(refusal(0, 0), HasSubstr("0×0"));
  EXPECT_THAT(refusal(-1, 5), HasSubstr("-1×5"));
  EXPECT_THAT(refusal(1 << 24, 1), HasSubstr("16777216×1"));
  const auto batch = render::Renderer::create(api(), {.batch = 129});
  EXPECT_THAT(batch.error().message(), HasSubstr("129"));

  gl::Capabilities weak = api().capabilities;
  weak.max_work_group_invocations = 127;
  EXPECT_THAT(gl::check_limits(weak).error().message(), HasSubstr("WORK_GROUP_INVOCATIONS"));
  weak = api().capabilities;
  weak.max_compute_storage_blocks = 3;
  EXPECT_THAT(gl::check_limits(weak).error().message(), HasSubstr("SHADER_STORAGE_BLOCKS"));
  weak = api().capabilities;
  weak.max_shared_memory_bytes = 16383;
  EXPECT_THAT(gl::check_limits(weak).error().message(), HasSubstr("SHARED_MEMORY"));
}

// As a Mali: the same image, bit for bit, with nothing but textures in the vertex stage.
TEST_P(RendererTest, DriversWithoutStorageInTheVertexStageUseTextures) {
  const SplatCloud cloud = random_cloud(5000, 1, 12);  // Several rows of the textures
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  must(renderer().upload(cloud));
  const Image<float> expected = draw(renderer(), camera);
  const int blocks = std::exchange(api().capabilities.max_vertex_storage_blocks, 0);
  const auto weak = must(render::Renderer::create(api()));
  api().capabilities.max_vertex_storage_blocks = blocks;
  EXPECT_TRUE(weak->settings().texture_fetch);
  must(weak->upload(cloud));
  EXPECT_EQ(draw(*weak, camera).pixels, expected.pixels);
  const auto half = must(render::Renderer::create(
      api(), {.splat_precision = render::SplatPrecision::half, .texture_fetch = true}));
  const auto half_stored =
      must(render::Renderer::create(api(), {.splat_precision = render::SplatPrecision::half}));
  must(half->upload(cloud));
  must(half_stored->upload(cloud));
  EXPECT_EQ(draw(*half, camera).pixels, draw(*half_stored, camera).pixels);
}

// What each approximation costs, against float64: none of them breaks the image.
TEST_P(RendererTest, ApproximationsCostWhatTheyMay) {
  const SplatCloud cloud = random_cloud(3000, 1, 13);
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  const ReferenceImage reference = render_reference(cloud, camera, {});
  const auto psnr = [&](const render::RendererSettings& settings, double scale) {
    const auto made = must(render::Renderer::create(api(), settings));
    must(made->upload(cloud));
    const RenderTarget target =
        must(RenderTarget::create(api(), camera.width, camera.height, TargetFormat::rgba16f,
                                  render::accurate_accumulation(api().capabilities), scale));
    must(made->draw(camera, {}, target));
    const Image<float> image = must(made->read(target));
    const double found = compare(image, reference, false).psnr;
    keep_image(std::string(host::name(GetParam())) + " approximation", image);
    std::printf("%-7s %.2f dB\n", std::string(host::name(GetParam())).c_str(), found);
    return found;
  };
  using render::SplatPrecision;
  EXPECT_GT(psnr({}, 1), 65);
  EXPECT_GT(psnr({.approximation = {.key_bits = 32}}, 1), 65);
  EXPECT_GT(psnr({.approximation = {.key_bits = 16}}, 1), 50);
  EXPECT_GT(psnr({.splat_precision = SplatPrecision::half}, 1), 45);
  EXPECT_GT(psnr({.approximation = {.max_deviations = 3}}, 1), 40);
  EXPECT_GT(psnr({.approximation = {.min_weight = 1}}, 1), 40);
  EXPECT_GT(psnr({}, 0.5), 20);
}

// An order is kept while the camera moves less than allowed; splats that come into view are there.
TEST_P(RendererTest, SmallMotionsKeepTheOrder) {
  const SplatCloud cloud = random_cloud(3000, 0, 14);
  const auto lazy =
      must(render::Renderer::create(api(), {.approximation = {.resort_motion = 0.05}}));
  must(lazy->upload(cloud));
  must(renderer().upload(cloud));
  const RenderTarget shown = target(80, 60);
  const auto difference = [&](const Camera& camera) {
    must(lazy->draw(camera, {}, shown));
    const Image<float> kept = must(lazy->read(shown));
    const Image<float> exact = draw(renderer(), camera);
    double sum = 0;
    for (std::size_t i = 0; i < kept.pixels.size(); ++i)
      sum += std::pow(static_cast<double>(kept.pixels[i] - exact.pixels[i]), 2);
    return std::sqrt(sum / static_cast<double>(kept.pixels.size()));
  };
  Camera camera = front_camera(80, 60, 1.2);
  EXPECT_EQ(difference(camera), 0);
  const auto order = must(lazy->sorter().order().read_all<std::uint32_t>(100));
  camera.translation.x += 0.04;  // 0.033 radians
  const double small = difference(camera);
  EXPECT_EQ(must(lazy->sorter().order().read_all<std::uint32_t>(100)), order);
  EXPECT_LT(small, 0.02);
  camera.translation.x += 0.04;
  EXPECT_EQ(difference(camera), 0);  // Sorted again
}

FLUXGS_GL_TEST_SUITE(RendererTest);

}  // namespace
}  // namespace fluxgs::test
