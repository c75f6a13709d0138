// The scene stays in view: contexts that are lost at any call, and GPUs with too little memory.
#include "render/scene_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "fluxgs/contribution.h"
#include "gl_faults.h"
#include "gl_fixture.h"
#include "render/memory_estimate.h"
#include "render/splat_budget.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

using render::SceneView;
using render::SceneViewSettings;
using testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48;
const Camera kCamera = orbit_camera(kWidth, kHeight, {}, 2, 1, 4);

std::shared_ptr<const render::RenderCloud> shared_cloud(std::size_t count, int degree = 1) {
  return std::make_shared<render::RenderCloud>(random_cloud(count, degree, 21));
}

class SceneViewTest : public GlTest {
 protected:
  void TearDown() override {
    if (!IsSkipped()) {
      api().lost = api().out_of_memory = false;
      api().debug.messages.clear();  // Calls were swallowed, and those that follow may be mistakes
    }
    GlTest::TearDown();
  }

  static Expected<Image<std::uint8_t>> image(SceneView& view, const Camera& camera = kCamera) {
    if (auto drawn = view.draw(camera, {}); !drawn) return std::unexpected(drawn.error());
    return view.read();
  }

  /// What images are blended in where memory is short.
  render::Accumulation coarse() {
    const gl::Capabilities& driver = api().capabilities;
    return driver.float_targets && driver.half_float_targets
               ? render::Accumulation::half_float
               : render::accurate_accumulation(driver);
  }

  void survive_a_loss_at_every_call(const SceneViewSettings& settings, bool reset_status);
};

TEST_P(SceneViewTest, ShowsWhatTheProcessorDrew) {
  std::vector<Camera> asked;
  SceneViewSettings settings;
  settings.software = [&](const Camera& camera, const RenderOptions&) {
    asked.push_back(camera);
    render::SoftwareFrame frame{.image = {camera.width, camera.height, 4}, .drawn = 7};
    for (std::size_t i = 0; i < frame.image.pixels.size(); ++i)
      frame.image.pixels[i] = static_cast<std::uint8_t>(i % 251);
    return frame;
  };
  SceneView view(shared_cloud(300), settings);
  must(view.open(device(), kWidth, kHeight));
  const Image<std::uint8_t> shown = must(image(view));
  EXPECT_TRUE(view.shows_all());
  EXPECT_EQ(view.drawn_in_software(), 7U);
  for (int y = 0; y < kHeight; ++y)
    for (int k = 0; k < 4 * kWidth; ++k)
      ASSERT_EQ(shown.pixels[static_cast<std::size_t>(4 * kWidth * y + k)],
                (4 * kWidth * y + k) % 251)
          << y << ' ' << k;
  // A smaller image is enlarged, and another size of the window means another image
  view.set_scale(0.5);
  EXPECT_EQ(must(image(view)).width, kWidth);
  EXPECT_EQ(asked.back().width, kWidth / 2);
  EXPECT_DOUBLE_EQ(asked.back().fx, kCamera.fx / 2);
  view.set_scale(1);
  const Camera other = orbit_camera(kWidth + 3, kHeight, {}, 2, 2, 4);
  EXPECT_EQ(must(image(view, other)).width, kWidth + 3);
  Camera unsound = kCamera;
  unsound.fx = 0;
  EXPECT_FALSE(view.draw(unsound, {}));
}

// Every call of a frame for which the image is made anew, of its reading and its counting:
// nothing hangs or crashes, it is noticed, and nothing that was left half done is in the images
// after.
void SceneViewTest::survive_a_loss_at_every_call(const SceneViewSettings& settings,
                                                 bool reset_status) {
  const GlFaults between(api(), reset_status);
  SceneView view(shared_cloud(300), settings);
  must(view.open(device(), kWidth, kHeight));
  const Camera other = orbit_camera(kWidth + 1, kHeight, {}, 2, 2, 4);
  const auto frame = [&] {
    auto found = image(view);
    static_cast<void>(view.renderer().stats());
    return found;
  };
  const Image<std::uint8_t> expected = must(frame());
  must(image(view, other));
  faults.calls = 0;
  must(frame());
  const long calls = faults.calls;
  ASSERT_GT(calls, 40);
  for (long call = 0; call < calls; ++call) {
    must(image(view, other));
    faults.calls = 0;
    faults.lost_after = call;
    static_cast<void>(frame());
    EXPECT_TRUE(gl::context_lost(api())) << call;
    const auto after = view.draw(kCamera, {});
    ASSERT_FALSE(after) << call << " of " << calls;
    EXPECT_THAT(after.error().message(), HasSubstr("the context was lost"));
    // As if it had been a bad dream
    faults.lost_after = -1;
    api().lost = false;
    ASSERT_EQ(must(frame()).pixels, expected.pixels) << call << " of " << calls;
  }
}

TEST_P(SceneViewTest, ALossAtAnyCallIsNoticedAndHarmless) {
  survive_a_loss_at_every_call({.renderer = {.timestamps = true}}, true);
  survive_a_loss_at_every_call({.renderer = {.sorter = render::SorterKind::exact}}, false);
}

// While the GL objects are made: an error, and what is made next is whole.
TEST_P(SceneViewTest, ALossDuringTheStartIsAnError) {
  const GlFaults between(api());
  const auto cloud = shared_cloud(300);
  long calls = 0;
  Image<std::uint8_t> expected;
  {
    SceneView view(cloud, {});
    must(view.open(device(), kWidth, kHeight));
    calls = faults.calls;
    expected = must(image(view));
  }
  // A few calls stand for all: most make programs, all alike, and slowly on some drivers
  const long step = calls / 7;
  for (long call = 0; call < calls; call += step) {
    faults.calls = 0;
    faults.lost_after = call;
    {
      SceneView view(cloud, {});
      EXPECT_FALSE(view.open(device(), kWidth, kHeight)) << call << " of " << calls;
      EXPECT_TRUE(gl::context_lost(api()));
    }
    faults.lost_after = -1;
    api().lost = false;
  }
  SceneView view(cloud, {});
  must(view.open(device(), kWidth, kHeight));
  EXPECT_EQ(must(image(view)).pixels, expected.pixels);
}

// Which call of a frame belongs to which stage.
std::vector<std::pair<const char*, long>> stages(gl::Api& api, SceneView& view) {
  static std::vector<std::pair<const char*, long>> found;
  static decltype(gl::Api::DispatchCompute) dispatch;
  static decltype(gl::Api::DrawElementsIndirect) draw;
  static decltype(gl::Api::DrawArrays) resolve;
  static decltype(gl::Api::ReadPixels) read;
  found.clear();
  dispatch = std::exchange(api.DispatchCompute, [](GLuint x, GLuint y, GLuint z) {
    found.emplace_back(found.empty() ? "project" : "sort", faults.calls);
    dispatch(x, y, z);
  });
  draw = std::exchange(api.DrawElementsIndirect, [](GLenum mode, GLenum type, const void* at) {
    found.emplace_back("draw", faults.calls);
    draw(mode, type, at);
  });
  resolve = std::exchange(api.DrawArrays, [](GLenum mode, GLint first, GLsizei count) {
    found.emplace_back("resolve", faults.calls);
    resolve(mode, first, count);
  });
  read = std::exchange(api.ReadPixels, [](GLint x, GLint y, GLsizei w, GLsizei h, GLenum format,
                                          GLenum type, void* to) {
    found.emplace_back("read", faults.calls);
    read(x, y, w, h, format, type, to);
  });
  faults.calls = 0;
  must(view.draw(kCamera, {}));
  must(view.read());
  api.DispatchCompute = dispatch;
  api.DrawElementsIndirect = draw;
  api.DrawArrays = resolve;
  api.ReadPixels = read;
  return found;
}

// As a phone has it: the context goes, and everything is made again in another one.
TEST_P(SceneViewTest, IsMadeAgainInANewContextWhateverStageLostTheOldOne) {
  SceneView view(shared_cloud(300), {});
  auto old = must(host::HostContext::create(GetParam()));
  auto old_device = std::make_unique<render::GlDevice>(old->api());
  must(view.open(*old_device, kWidth, kHeight));
  const Image<std::uint8_t> expected = must(image(view, kCamera));
  std::vector<std::pair<const char*, long>> all;
  {
    const GlFaults between(old->api());
    all = stages(old->api(), view);
  }
  std::string before;
  for (const auto& [stage, call] : all) {
    if (before == stage) continue;  // The first of each
    before = stage;
    {
      const GlFaults between(old->api());
      faults.lost_after = call;
      static_cast<void>(image(view, kCamera));
      EXPECT_TRUE(gl::context_lost(old->api())) << stage;
    }
    auto fresh = must(host::HostContext::create(GetParam()));
    auto fresh_device = std::make_unique<render::GlDevice>(fresh->api());
    must(view.open(*fresh_device, kWidth, kHeight));
    old_device = std::move(fresh_device);
    old = std::move(fresh);
    must(old->make_current());
    EXPECT_EQ(must(image(view, kCamera)).pixels, expected.pixels) << stage;
    EXPECT_TRUE(old->api().debug.mistakes().empty());
  }
  EXPECT_GE(all.size(), 5U);
  view.close();
}

TEST_P(SceneViewTest, ShowsWhatTheMemoryHolds) {
  const auto cloud = shared_cloud(5000);
  const GlFaults between(api());
  SceneView all(cloud, {});
  must(all.open(device(), kWidth, kHeight));
  must(image(all));
  EXPECT_TRUE(all.shows_all());
  all.close();
  EXPECT_EQ(faults.used, 0U) << "something was not deleted";

  // By the estimate: never, not even in between, more than was granted
  const std::size_t budget = faults.max_used / 2;
  faults.max_used = 0;
  SceneView some(cloud, {.memory = budget});
  must(some.open(device(), kWidth, kHeight));
  const Image<std::uint8_t> shown = must(image(some));
  EXPECT_FALSE(some.shows_all());
  EXPECT_GT(some.splats(), 1000U);
  const std::size_t splats = some.splats();
  EXPECT_GT(faults.used, budget * 3 / 4);
  // A larger image leaves room for fewer splats, and the first one again for as many
  must(image(some, orbit_camera(2 * kWidth, kHeight, {}, 2, 1, 4)));
  EXPECT_LT(some.splats(), splats);
  EXPECT_EQ(must(image(some)).pixels, shown.pixels);
  EXPECT_EQ(some.splats(), splats);
  EXPECT_LE(faults.max_used, budget);

  // They are the ones that add most
  SceneView selected(std::make_shared<render::RenderCloud>(in_order(
                         random_cloud(5000, 1, 21), render::max_contributing(cloud->base, splats))),
                     {.accumulation = coarse()});
  must(selected.open(device(), kWidth, kHeight));
  EXPECT_EQ(must(image(selected)).pixels, shown.pixels);
}

TEST_P(SceneViewTest, GivesWayWhereTheDriverHasLessThanItSays) {
  const auto cloud = shared_cloud(5000);
  const GlFaults between(api());
  SceneView view(cloud, {});
  must(view.open(device(), kWidth, kHeight));
  must(image(view));
  faults.memory = faults.used * 3 / 5;
  must(view.open(device(), kWidth, kHeight));
  EXPECT_FALSE(api().lost);
  EXPECT_GT(view.splats(), 5000U / 3);
  EXPECT_LT(view.splats(), 5000U * 3 / 5);
  must(image(view));
  EXPECT_LE(faults.used, faults.memory);
  // Less and less while it runs: seen when the image changes its size
  faults.memory = faults.memory / 2;
  const std::size_t before = view.splats();
  must(image(view, orbit_camera(kWidth + 2, kHeight, {}, 2, 1, 4)));
  EXPECT_LT(view.splats(), before);
  EXPECT_GT(view.splats(), 0U);
  // Nothing at all: an error, and an image again once there is room
  const std::size_t some = std::exchange(faults.memory, 1000);
  const auto refused = image(view);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("out of graphics memory"));
  EXPECT_FALSE(image(view));
  faults.memory = 2 * some;
  must(image(view));
  EXPECT_GT(view.splats(), before / 2);
}

// In the end fewer pixels: half of the memory is the splats'.
TEST_P(SceneViewTest, AImageThatDoesNotFitIsMadeSmaller) {
  const auto cloud = shared_cloud(300);
  const Camera large = orbit_camera(8 * kWidth, 8 * kHeight, {}, 2, 1, 4);
  const GlFaults between(api());
  {
    SceneView view(cloud, {.memory = 800'000});
    must(view.open(device(), large.width, large.height));
    must(image(view, large));
    EXPECT_LT(view.image_size().width, large.width);
    EXPECT_GE(view.image_size().width, kWidth);
    EXPECT_EQ(view.image_size().width * large.height, view.image_size().height * large.width);
    EXPECT_TRUE(view.shows_all());
    EXPECT_LE(faults.max_used, 800'000U);
    must(image(view));
    EXPECT_EQ(view.image_size().width, kWidth);
  }
  // The driver says no: the same, and the scene as it would be drawn at that size
  faults.memory = 800'000;
  SceneView view(cloud, {});
  must(view.open(device(), large.width, large.height));
  const Image<std::uint8_t> shown = must(image(view, large));
  ASSERT_LT(shown.width, large.width);
  faults.memory = ~0UL;
  SceneView small(
      std::make_shared<render::RenderCloud>(
          in_order(random_cloud(300, 1, 21), render::max_contributing(cloud->base, view.splats()))),
      {.accumulation = coarse()});
  must(small.open(device(), shown.width, shown.height));
  EXPECT_EQ(must(image(small, orbit_camera(shown.width, shown.height, {}, 2, 1, 4))).pixels,
            shown.pixels);
}

// Half floats cost a rounding that few see, half of the pixels what everybody does.
TEST_P(SceneViewTest, HalfFloatsThenSplatsThenPixels) {
  if (!api().capabilities.float_targets) GTEST_SKIP() << "has none that could be given up";
  // a graphics card starts with half floats
  const bool on_cpu = std::exchange(api().quirks.runs_on_cpu, true);
  const GlFaults between(api());
  const Camera camera = orbit_camera(4 * kWidth, 4 * kHeight, {}, 2, 1, 4);
  const std::size_t pixels = std::size_t{16} * kWidth * kHeight;
  struct Opened {
    int width = 0;
    std::size_t memory = 0, splats = 0;
  };
  for (const std::size_t splats : {10U, 20'000U}) {  // less than the image, and more
    const auto cloud = shared_cloud(splats);
    const auto opened = [&](const SceneViewSettings& settings) {
      SceneView view(cloud, settings);
      must(view.open(device(), camera.width, camera.height));
      must(image(view, camera));
      EXPECT_EQ(faults.used, view.memory());
      EXPECT_EQ(view.is_reduced(), settings.memory.has_value());
      return Opened{view.image_size().width, view.memory(), view.splats()};
    };
    const Opened whole = opened({});
    const Opened half = opened({.memory = whole.memory - 1});
    EXPECT_EQ(half.width, camera.width);
    EXPECT_EQ(half.splats, splats);
    EXPECT_EQ(whole.memory - half.memory, 8 * pixels);
    const Opened less = opened({.memory = half.memory - 1});
    if (splats == 10) {
      EXPECT_EQ(less.width, camera.width / 2);
      EXPECT_EQ(less.splats, splats);
    } else {
      EXPECT_EQ(less.width, camera.width);
      EXPECT_LT(less.splats, splats);
      EXPECT_GT(less.splats, splats * 9 / 10);
    }
    // The driver says no, where nobody knew
    faults.memory = half.memory;
    SceneView told(cloud, {});
    must(told.open(device(), camera.width, camera.height));
    EXPECT_EQ(told.splats(), splats);
    EXPECT_EQ(told.memory(), half.memory);
    told.close();
    faults.memory = ~0UL;
    // What is asked for is given
    SceneView asked(
        cloud, {.accumulation = render::Accumulation::single_float, .memory = whole.memory - 1});
    must(asked.open(device(), camera.width, camera.height));
    EXPECT_TRUE(asked.splats() < splats || asked.image_size().width < camera.width);
  }
  api().quirks.runs_on_cpu = on_cpu;
}

// The scale changes while something moves: the splats are not to come and go with it.
TEST_P(SceneViewTest, AnotherScaleIsAnotherImageOfTheSameSplats) {
  const GlFaults between(api());
  const auto cloud = shared_cloud(5000);
  SceneView whole(cloud, {});
  must(whole.open(device(), kWidth, kHeight));
  must(image(whole));
  const std::size_t budget = whole.memory() / 2;
  whole.close();
  SceneView view(cloud, {.memory = budget});
  must(view.open(device(), kWidth, kHeight));
  const Image<std::uint8_t> first = must(image(view));
  const std::size_t splats = view.splats();
  EXPECT_LT(splats, 5000U);
  faults.max_used = 0;
  for (const double scale : {0.5, 0.85, 0.3, 1.0}) {
    const long before = faults.allocations;
    view.set_scale(scale);
    must(image(view));
    EXPECT_EQ(view.splats(), splats) << scale;
    EXPECT_LE(faults.allocations - before, 1) << scale << ": more than what it was read with";
    EXPECT_LE(faults.max_used, budget) << scale;
  }
  EXPECT_EQ(must(image(view)).pixels, first.pixels);
}

TEST_P(SceneViewTest, AMemoryThatHoldsNothingIsRefused) {
  SceneView view(shared_cloud(10), {.memory = 1000});
  const auto opened = view.open(device(), kWidth, kHeight);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message(),
              HasSubstr("graphics memory: 1000 bytes do not hold one pixel and one splat"));
}

TEST_P(SceneViewTest, TheLimitsOfTheDriverAreABudget) {
  const auto limit = std::exchange(api().capabilities.max_storage_block_bytes, 64 * 1000);
  SceneView view(shared_cloud(5000, 0), {});
  const auto opened = view.open(device(), kWidth, kHeight);
  api().capabilities.max_storage_block_bytes = limit;
  must(opened);
  EXPECT_EQ(view.splats(), 1000U);
}

// Where degrees are mixed a budget holds more splats than if all had the highest, and is kept.
TEST_P(SceneViewTest, SplatsOfLowDegreesTakeLessOfABudget) {
  const auto mixed = std::make_shared<render::RenderCloud>(mixed_cloud(5000, 3));
  const GlFaults between(api());
  const std::size_t budget = 700'000;
  SceneView some(mixed, {.memory = budget});
  must(some.open(device(), kWidth, kHeight));
  must(image(some));
  EXPECT_LE(faults.max_used, budget);
  EXPECT_GT(faults.used, budget / 2);
  const std::size_t splats = some.splats();
  EXPECT_FALSE(some.shows_all());
  some.close();
  SceneView full(std::make_shared<render::RenderCloud>(random_cloud(5000, 3, 3)),
                 {.memory = budget});
  must(full.open(device(), kWidth, kHeight));
  EXPECT_GT(splats, full.splats());
}

// What few see goes before what is seen: degrees 3 and 2, then splats.
TEST_P(SceneViewTest, HarmonicsGoBeforeSplats) {
  const auto cloud = shared_cloud(5000, 3);
  const GlFaults between(api());
  SceneView all(cloud, {.accumulation = coarse()});
  must(all.open(device(), kWidth, kHeight));
  must(image(all));
  EXPECT_EQ(all.sh_degree(), 3);
  const std::size_t whole = all.memory();
  all.close();
  const auto with = [&](std::size_t memory) {
    SceneView view(cloud, {.memory = memory});
    must(view.open(device(), kWidth, kHeight));
    must(image(view));
    EXPECT_LE(view.memory(), memory);
    EXPECT_TRUE(view.is_reduced());
    EXPECT_FALSE(view.shows_all());
    return std::pair(view.splats(), view.sh_degree());
  };
  constexpr std::size_t kSplats = 5000, kReading = 50'000;  // an image is read on the way
  EXPECT_EQ(with(whole + kReading - (96 - 48) * kSplats), std::pair(kSplats, 2));
  EXPECT_EQ(with(whole + kReading - (96 - 24) * kSplats), std::pair(kSplats, 1));
  const auto [splats, degree] = with(whole - 96 * kSplats);
  EXPECT_LT(splats, kSplats);
  EXPECT_EQ(degree, 1);
  // The driver has less than it says
  faults.memory = whole - 30 * kSplats;
  SceneView told(cloud, {.accumulation = coarse()});
  must(told.open(device(), kWidth, kHeight));
  EXPECT_EQ(told.splats(), kSplats);
  EXPECT_EQ(told.sh_degree(), 2);
}

TEST_P(SceneViewTest, AnEmptySceneIsShown) {
  SceneView view(std::make_shared<render::RenderCloud>(), {});
  must(view.open(device(), kWidth, kHeight));
  EXPECT_TRUE(view.shows_all());
  for (const float value : must(image(view)).pixels) ASSERT_EQ(value, 0.0F);
}

FLUXGS_GL_TEST_SUITE(SceneViewTest);

TEST(SplatBudget, ContributionIsOpacityTimesMeanArea) {
  SplatCloud cloud;
  add(cloud, {.scale = {1, 2, 3}, .opacity = 0.5F});
  add(cloud, {});
  cloud.log_scales[1].x = std::nanf("");
  EXPECT_NEAR(contribution(cloud, 0), 0.5 * 11 / 3, 1e-6);
  EXPECT_EQ(contribution(cloud, 1), 0);
}

TEST(SplatBudget, TheLeastGoFirstAndTiesByIndex) {
  SplatCloud cloud;
  for (const float size : {1.0F, 3.0F, 2.0F, 1.0F, 3.0F}) add(cloud, {.scale = glm::vec3(size)});
  using Indices = std::vector<std::uint32_t>;
  EXPECT_EQ(render::max_contributing(cloud, 0), (Indices{}));
  EXPECT_EQ(render::max_contributing(cloud, 1), (Indices{1}));
  EXPECT_EQ(render::max_contributing(cloud, 3), (Indices{1, 2, 4}));
  EXPECT_EQ(render::max_contributing(cloud, 4), (Indices{0, 1, 2, 4}));
  EXPECT_EQ(render::max_contributing(cloud, 9), (Indices{0, 1, 2, 3, 4}));
}

}  // namespace
}  // namespace fluxgs::test
