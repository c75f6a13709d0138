// Defects of drivers, played one at a time: the right picture all the same, or the reason why not.
#include <gmock/gmock.h>

#include "bench/driver_check.h"
#include "gl_faults.h"
#include "image_fixture.h"
#include "render/scene_view.h"

namespace fluxgs::test {
namespace {

using bench::DriverCheck;
using render::DriverLimits;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Sample {
  SplatCloud cloud;
  Camera camera;
  double near_plane = 0;
  Image<std::uint8_t> golden = {};
};

/// A scene and its picture by the reference: another one each time, as drivers hand memory out
/// again with what a drawing before has left there.
Sample next_sample() {
  static std::uint32_t seed = 50;
  Sample s{.cloud = random_cloud(3000, 1, ++seed),
           .camera = orbit_camera(128, 128, {}, 2.5, 1, 4),
           .near_plane = RenderOptions().near_plane};
  s.golden = in_bytes(render_reference(s.cloud, s.camera, {}).color);
  return s;
}

class HostileDriversTest : public ImageTest {
 protected:
  DriverCheck check() {
    const Sample s = next_sample();
    DriverCheck done = bench::check_driver(api(), s.cloud, s.camera, s.near_plane, s.golden);
    std::printf("%-7s %s\n", std::string(host::name(GetParam())).c_str(),
                bench::to_json(done, api()).c_str());
    return done;
  }

  DriverCheck check(const Defects& defects) {
    const GlFaults between(api());
    faults.defects = defects;
    DriverCheck done = check();
    gl::clear_errors(api());
    api().debug.messages.clear();  // of what was played
    return done;
  }
};

TEST_P(HostileDriversTest, AGoodDriverNeedsNoLimits) {
  const DriverCheck done = check();
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, DriverLimits());
  EXPECT_THAT(done.faults, IsEmpty());
  EXPECT_GE(done.psnr, 50);
}

TEST_P(HostileDriversTest, AForgottenElementBufferIsBoundAgain) {
  const DriverCheck done = check({.forgets_element_buffer = true});
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, DriverLimits());
}

TEST_P(HostileDriversTest, DrawsThatFailAreNamed) {
  const DriverCheck done = check({.fails_draws = true});
  EXPECT_TRUE(done.right);  // by draws that are not indirect
  EXPECT_EQ(done.limits, DriverLimits{.no_compute = true});
  EXPECT_THAT(done.faults.front(), HasSubstr("drawing: GL_INVALID_OPERATION"));
}

TEST_P(HostileDriversTest, WhatTheDriverSaysIsKept) {
  const Sample s = next_sample();
  api().debug.messages.push_back({gl::Severity::high, gl::MessageKind::error, "before"});
  static gl::DebugLog* log = nullptr;
  static decltype(gl::Api::Viewport) viewport = nullptr;
  log = &api().debug;
  viewport = std::exchange(api().Viewport, [](GLint x, GLint y, GLsizei w, GLsizei h) {
    log->messages.push_back({gl::Severity::high, gl::MessageKind::error, std::string(1000, 'x')});
    log->messages.push_back({gl::Severity::low, gl::MessageKind::performance, "slow"});
    viewport(x, y, w, h);
  });
  const DriverCheck done = bench::check_driver(api(), s.cloud, s.camera, s.near_plane, s.golden);
  api().Viewport = viewport;
  api().debug.messages.clear();
  ASSERT_FALSE(done.messages.empty());
  EXPECT_EQ(done.messages.front(), std::string(300, 'x'));
  EXPECT_LE(done.messages.size(), 8U);
}

TEST_P(HostileDriversTest, AProjectionThatIsWrongIsNamed) {
  const DriverCheck done = check({.shifts_projection = true});
  EXPECT_FALSE(done.right);
  EXPECT_THAT(done.faults.front(), HasSubstr("the projection put "));
}

TEST_P(HostileDriversTest, VertexStorageGivesWayToTextures) {
  if (api().capabilities.max_vertex_storage_blocks < 2) GTEST_SKIP() << "has none";
  const DriverCheck done = check({.loses_vertex_storage = true});
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, DriverLimits{.no_vertex_storage = true});
  EXPECT_THAT(done.faults, ElementsAre(HasSubstr("the picture is")));
}

TEST_P(HostileDriversTest, ASortThatLosesWorkGivesWayToTheProcessor) {
  const DriverCheck done = check({.loses_dispatches = true});
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, DriverLimits{.no_gpu_sort = true});
  EXPECT_THAT(done.faults, ElementsAre(HasSubstr("the sort ")));
}

TEST_P(HostileDriversTest, FloatTargetsGiveWayToBytes) {
  const DriverCheck done = check({.refuses_float_targets = true});
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, DriverLimits{.no_float_targets = true});
  EXPECT_THAT(done.faults, ElementsAre(HasSubstr("cannot render to this format")));
}

TEST_P(HostileDriversTest, ProgramsThatDoNotLinkHaveARemedyWhereThereIsOne) {
  const DriverCheck sorted = check({.unlinkable = "uint find_starts("});
  EXPECT_TRUE(sorted.right);
  EXPECT_EQ(sorted.limits, DriverLimits{.no_gpu_sort = true});
  EXPECT_THAT(sorted.faults, ElementsAre(HasSubstr("sort_scatter.comp")));
  const DriverCheck projected = check({.unlinkable = "one thread reads one splat"});
  EXPECT_TRUE(projected.right);
  EXPECT_EQ(projected.limits, DriverLimits{.no_compute = true});
  EXPECT_THAT(projected.faults, ElementsAre(HasSubstr("project.comp")));
  const DriverCheck none = check({.unlinkable = "Culls and projects a splat"});
  EXPECT_FALSE(none.right);
  EXPECT_THAT(none.faults.front(), HasSubstr("project.comp"));
}

TEST_P(HostileDriversTest, CoarseFragmentsGiveWayToVertices) {
  const DriverCheck done =
      check({.unlinkable = "one thread reads one splat", .coarse_fragments = true});
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, (DriverLimits{.no_compute = true, .no_fragment_projection = true}));
  EXPECT_THAT(done.faults, ElementsAre(HasSubstr("project.comp"), HasSubstr("the projection put")));
}

TEST_P(HostileDriversTest, TwoDefectsHaveTwoRemedies) {
  if (api().capabilities.max_vertex_storage_blocks < 2) GTEST_SKIP() << "has none";
  const DriverCheck done = check({.loses_vertex_storage = true, .loses_dispatches = true});
  EXPECT_TRUE(done.right);
  EXPECT_EQ(done.limits, (DriverLimits{.no_gpu_sort = true, .no_vertex_storage = true}));
}

TEST_P(HostileDriversTest, AContextLostAtAnyCallEndsTheCheck) {
  const GlFaults between(api());
  check();
  const long calls = faults.calls * 9 / 10;  // the last ones delete
  for (long after = 0; after < calls; after += std::max(1L, calls / 12)) {
    faults.lost_after = faults.calls + after;
    EXPECT_FALSE(check().right) << after;
    faults.lost_after = -1;
    api().lost = false;
  }
  gl::clear_errors(api());
}

// Times that make no sense are left out; counts do not depend on them.
TEST_P(HostileDriversTest, AWildClockIsNotBelieved) {
  if (!api().capabilities.timestamps) GTEST_SKIP() << "has no clock";
  const Sample s = next_sample();
  const GlFaults between(api());
  faults.defects.wild_clock = true;
  const auto timed = must(render::Renderer::create(api(), {.timestamps = true}));
  must(timed->upload(s.cloud));
  const RenderTarget target = must(RenderTarget::create(api(), 64, 64, TargetFormat::rgba8));
  for (int i = 0; i < 5; ++i) {
    must(timed->draw(front_camera(64, 64, 3), {}, target));
    const render::FrameStats stats = must(timed->stats());
    EXPECT_GT(stats.drawn, 1000U);
    EXPECT_FALSE(stats.stages);
  }
}

TEST_P(HostileDriversTest, FramesAreMeasuredWithoutWaiting) {
  const Sample s = next_sample();
  const auto timed = must(render::Renderer::create(api(), {.timestamps = true}));
  must(timed->upload(s.cloud));
  const RenderTarget target = must(RenderTarget::create(api(), 64, 64, TargetFormat::rgba8));
  EXPECT_FALSE(must(timed->finished_stats()));
  must(timed->draw(front_camera(64, 64, 3), {}, target));
  api().Finish();
  const auto finished = must(timed->finished_stats());
  ASSERT_TRUE(finished);
  EXPECT_EQ(finished->drawn, must(timed->stats()).drawn);
  EXPECT_FALSE(must(timed->finished_stats())) << "it was spoken of";
  const GlFaults between(api());
  faults.defects.slow = true;
  must(timed->draw(front_camera(64, 64, 3), {}, target));
  EXPECT_FALSE(must(timed->finished_stats())) << "nobody waits";
  faults.defects.slow = false;
  api().Finish();
  EXPECT_TRUE(must(timed->finished_stats()));
  timed->measure(false);
  const long before = faults.fences;
  must(timed->draw(front_camera(64, 64, 3), {}, target));
  EXPECT_EQ(faults.fences, before);
}

TEST_P(HostileDriversTest, TheViewerNamesFirstFramesThatFail) {
  const Sample s = next_sample();
  render::SceneView view(std::make_shared<const render::RenderCloud>(s.cloud), {});
  must(view.open(device(), s.camera.width, s.camera.height));
  {
    const GlFaults between(api());
    faults.defects.fails_draws = true;
    const auto drawn = view.draw(s.camera, {});
    ASSERT_FALSE(drawn);
    EXPECT_THAT(drawn.error().message(), HasSubstr("drawing: GL_INVALID_OPERATION"));
  }
  must(view.draw(s.camera, {}));
}

FLUXGS_GL_TEST_SUITE(HostileDriversTest);

}  // namespace
}  // namespace fluxgs::test
