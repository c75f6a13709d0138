// The off-screen protocol, and the model of what a frame moves.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "bench/frame_benchmark.h"
#include "gl_fixture.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

TEST(Summary, OfKnownSamples) {
  const bench::Summary s = bench::summarize({4, 1, 3, 2});
  EXPECT_EQ(s.mean, 2.5);
  EXPECT_EQ(s.median, 2.5);
  EXPECT_EQ(s.p95, 4);
  EXPECT_EQ(s.least, 1);
  std::vector<double> many(100);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<double>(i + 1);
  EXPECT_EQ(bench::summarize(many).p95, 95);
  EXPECT_EQ(bench::summarize({}).median, 0);
}

TEST(AreaInside, OfQuadsAcrossTheBorder) {
  const auto box = [](double x0, double y0, double x1, double y1) {
    return bench::Quad{{x0, x1, x1, x0}, {y0, y0, y1, y1}};
  };
  EXPECT_DOUBLE_EQ(bench::area_inside(box(2, 3, 5, 7), 10, 10), 12);
  EXPECT_DOUBLE_EQ(bench::area_inside(box(-5, -5, 5, 5), 10, 10), 25);
  EXPECT_DOUBLE_EQ(bench::area_inside(box(-50, -50, 50, 50), 10, 8), 80);
  EXPECT_DOUBLE_EQ(bench::area_inside(box(20, 20, 30, 30), 10, 10), 0);
  // A diamond half of which lies left of the image
  EXPECT_DOUBLE_EQ(bench::area_inside({{-3, 0, 3, 0}, {5, 2, 5, 8}}, 10, 10), 9);
}

TEST(TrafficModel, CountsEveryByteOfASmallFrame) {
  bench::FrameCounts counts{.splats = 4096,
                            .in_front = 3000,
                            .drawn = 2048,
                            .fragments = 1e6,
                            .key_bits = 24,
                            .evaluated = {500, 1024, 500, 24}};
  const render::TargetPlan target{.width = 100, .height = 50};
  const bench::FrameTraffic t = bench::model_traffic(counts, {}, target);
  EXPECT_EQ(t.project, 4096 * 16 + 3000 * 48 + 1024 * 24 + 500 * 48 + 24 * 96 + 4096 * 4 +
                           2048 * 4 + 2048 * 32);
  const double tables = 256 * 4 * 5;                     // of one block
  EXPECT_EQ(t.sort, 2 * tables + 4096 * 8 + 2048 * 8     // first pass
                        + tables + 2048 * (8 + 8 + 8)    // second
                        + tables + 2048 * (8 + 8 + 4));  // last
  EXPECT_EQ(t.vertices, 2048 * 36);
  EXPECT_EQ(t.resolve, 0);
  EXPECT_EQ(t.blend_tiled, 5000 * 4);
  EXPECT_EQ(t.blend_immediate, (2e6 + 5000) * 4);
  const bench::FrameTraffic float_blended = bench::model_traffic(
      counts, {}, {.width = 100, .height = 50, .accumulation = render::Accumulation::single_float});
  EXPECT_EQ(float_blended.resolve, 5000 * 20);
  EXPECT_EQ(float_blended.blend_tiled, 5000 * 16);
}

class BenchTest : public GlTest {};

TEST_P(BenchTest, TimesFramesAndLeavesTheRendererAsItWas) {
  const SplatCloud cloud = random_cloud(500, 1, 1);
  const render::ApproximationSettings approximation{.key_bits = 20, .min_weight = 0.5};
  const auto made = must(render::Renderer::create(api(), {.sorter = render::SorterKind::cpu_async,
                                                          .timestamps = true,
                                                          .approximation = approximation}));
  must(made->upload(cloud));
  const auto target =
      must(render::RenderTarget::create(api(), 64, 48, render::TargetFormat::rgba8));
  const std::vector<Camera> views = {orbit_camera(64, 48, {}, 2, 0, 3),
                                     orbit_camera(64, 48, {}, 2, 1, 3)};
  int told = 0, all = 0;
  const auto result = must(bench::benchmark_frames(
      api(), *made, target, views, {}, {.warmup = 2, .frames = 6}, [&](int done, int of) {
        told = done;
        all = of;
        return true;
      }));
  EXPECT_EQ(told, all);
  EXPECT_EQ(all, 2 + 4 * 6);
  EXPECT_GT(result.in_flight_ms.median, 0);
  EXPECT_GE(result.in_flight_ms.p95, result.in_flight_ms.median);
  EXPECT_GT(result.draw_ms.median, 0);
  EXPECT_GE(result.draw_ms.p95, result.draw_ms.median);
  EXPECT_GT(result.sort_to_display_ms.median, 0);
  EXPECT_GT(result.pipelined_ms, 0);
  EXPECT_EQ(result.stages.has_value(), api().capabilities.timestamps);
  EXPECT_EQ(made->settings().approximation.key_bits, 20);
  EXPECT_EQ(made->settings().approximation.min_weight, 0.5);
  EXPECT_EQ(made->settings().approximation.resort_motion, 0);
}

TEST_P(BenchTest, StopsWhenItIsTold) {
  must(renderer().upload(random_cloud(50, 0, 1)));
  const auto target =
      must(render::RenderTarget::create(api(), 64, 48, render::TargetFormat::rgba8));
  const std::vector<Camera> views = {orbit_camera(64, 48, {}, 2, 0, 3)};
  const auto result =
      bench::benchmark_frames(api(), renderer(), target, views, {}, {.warmup = 2, .frames = 6},
                              [](int done, int) { return done < 3; });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().what, bench::kStopped);
}

TEST_P(BenchTest, StopsAmongTheFramesThatAreNotWaitedFor) {
  must(renderer().upload(random_cloud(50, 0, 1)));
  const auto target =
      must(render::RenderTarget::create(api(), 64, 48, render::TargetFormat::rgba8));
  const std::vector<Camera> views = {orbit_camera(64, 48, {}, 2, 0, 3)};
  for (const int last : {2 + 2 * 6 + 2, 2 + 3 * 6 + 2}) {
    int told = 0;
    const auto result = bench::benchmark_frames(api(), renderer(), target, views, {},
                                                {.warmup = 2, .frames = 6}, [&](int done, int) {
                                                  told = done;
                                                  return done < last;
                                                });
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().what, bench::kStopped);
    EXPECT_EQ(told, last);
  }
}

// The model's fragments and vertices against the driver's own counters, which only desktop GL has.
TEST_P(BenchTest, FragmentsAreThoseThatTheDriverCounts) {
  if (api().capabilities.is_es) GTEST_SKIP() << "ES 3.1 has no such counter";
  const SplatCloud cloud = random_cloud(3000, 0, 2);
  const Camera camera = orbit_camera(320, 240, {}, 2, 1, 4);
  must(renderer().upload(cloud));
  const auto target = must(render::RenderTarget::create(
      api(), 320, 240, render::TargetFormat::rgba8, render::Accumulation::direct));
  constexpr GLenum kSamplesPassed = 0x8914;
  constexpr GLenum kVertexInvocations = 0x82F0;  // GL_ARB_pipeline_statistics_query
  const auto counted = [&](GLenum what) {
    GLuint query = 0;
    api().GenQueries(1, &query);
    api().BeginQuery(what, query);
    must(renderer().draw(camera, {}, target));
    api().EndQuery(what);
    GLuint64 value = 0;
    api().GetQueryObjectui64v(query, GL_QUERY_RESULT, &value);
    api().DeleteQueries(1, &query);
    return static_cast<double>(value);
  };
  const double passed = counted(kSamplesPassed), vertices = counted(kVertexInvocations);
  const auto counts = must(bench::count_frame(renderer(), cloud, camera, {}, target));
  std::printf("fragments: %.0f, of which in the ellipse %.0f by the model, %.0f by the counter\n",
              counts.fragments, counts.fragments * std::numbers::pi / 4, passed);
  // Those in the quad but outside of the ellipse are discarded and not counted; a quad is wider
  // than its ellipse by 1/16 px on each side.
  EXPECT_NEAR(passed / (counts.fragments * std::numbers::pi / 4), 0.97, 0.04);
  EXPECT_EQ(vertices, std::ceil(static_cast<double>(counts.drawn) / 128) * 128 * 4);
}

FLUXGS_GL_TEST_SUITE(BenchTest);

}  // namespace
}  // namespace fluxgs::test
