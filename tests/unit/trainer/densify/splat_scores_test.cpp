// Metric maps, and scores against float64.
#include "trainer/densify/splat_scores.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/scenes.h"
#include "tools/reference/reference_renderer.h"
#include "trainer/densify/mask_pruning.h"
#include "trainer/densify/metric_maps.h"
#include "trainer/loss/photometric.h"

namespace fluxgs {
namespace {

PlanarImage waves(int width, int height, double frequency) {
  PlanarImage image(width, height, 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        image.row(c, y)[x] = static_cast<float>(0.5 + 0.4 * std::sin(frequency * (x + 2 * y) + c));
  return image;
}

double mean(const PlanarImage& map) {
  double total = 0;
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) total += double{map.row(0, y)[x]};
  return total / (map.width() * map.height());
}

TEST(MetricMaps, TheLossOfPixelsIsTheLossOfTheImage) {
  const PlanarImage a = waves(53, 37, 0.3), b = waves(53, 37, 0.33);
  const Threads threads(2);
  const PhotometricSums sums = PhotometricLoss(threads).run(a, b, 0.2);
  EXPECT_NEAR(mean(loss_map(a, b, 0.2, threads)), sums.loss(0.2), 1e-6);
  EXPECT_NEAR(mean(loss_map(a, b, 0, threads)), sums.l1, 1e-6);
}

TEST(MetricMaps, ThresholdsAreMultiplesOfAPercentileOrPlain) {
  PlanarImage loss(20, 10, 1);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) loss.row(0, y)[x] = 0.001f * static_cast<float>(20 * y + x);
  loss.row(0, 9)[19] = 1000;  // one outlier does not move the unit
  ScoreOptions options;       // percentile of about 0.198
  PlanarImage maps = metric_maps(loss, options);
  EXPECT_EQ(maps.row(0, 0)[19], 0);            // 0.019 < 0.1·0.198
  EXPECT_EQ(maps.row(0, 1)[0], 1);             // 0.020
  EXPECT_FLOAT_EQ(maps.row(1, 0)[1], 0.001f);  // ℒ·M⁻ is the loss below 0.01·0.198
  EXPECT_EQ(maps.row(1, 0)[2], 0);
  options.unit = ScoreUnit::raw;
  maps = metric_maps(loss, options);
  EXPECT_EQ(maps.row(0, 5)[0], 0);  // 0.1 is not above 0.1
  EXPECT_EQ(maps.row(0, 5)[1], 1);
}

TEST(MetricMaps, APerfectImageHasNoBadPixelsAndNanIsBad) {
  PlanarImage loss(8, 8, 1);
  ScoreOptions options;
  EXPECT_EQ(mean(metric_maps(loss, options)), 0);
  for (int x = 0; x < 8; ++x) loss.row(0, 3)[x] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(mean(metric_maps(loss, options)), 1.0 / 8);
}

TEST(MetricMaps, MaskedPixelsAreNeitherGoodNorBadNorInThePercentile) {
  PlanarImage loss(20, 10, 1);
  Image<std::uint8_t> used(20, 10, 1);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) {
      *used.at(x, y) = y < 5 ? 255 : 0;
      loss.row(0, y)[x] = y < 5 ? 0.001f * static_cast<float>(20 * y + x) : 3.0f;
    }
  ScoreOptions options;  // percentile of about 0.098
  const PlanarImage maps = metric_maps(loss, options, used);
  ASSERT_EQ(maps.channels(), 3);
  EXPECT_EQ(maps.row(0, 0)[9], 0);
  EXPECT_EQ(maps.row(0, 0)[10], 1);
  for (int x = 0; x < 20; ++x) {
    EXPECT_EQ(maps.row(0, 7)[x], 0);
    EXPECT_EQ(maps.row(1, 7)[x], 0);
    EXPECT_EQ(maps.row(2, 7)[x], 0);
    EXPECT_EQ(maps.row(2, 2)[x], 1);
  }
}

/// The scores by brute force.
struct Sums {
  double first = 0, second = 0, contribution = 0, pixels = 0;
};
std::vector<Sums> reference_scores(const SplatCloud& cloud, const Camera& camera,
                                   const RenderOptions& o, const PlanarImage& maps,
                                   ScoreWeight weight) {
  std::vector<Sums> sums(cloud.size());
  const auto splats = project_reference(cloud, camera, o);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      double t = 1;
      for (const ReferenceSplat& s : splats) {
        if (t < o.transmittance_min) break;
        const double dx = x + 0.5 - s.x, dy = y + 0.5 - s.y;
        const double u = s.xx * dx + s.xy * dy, v = s.yy * dy;
        const double raw = s.opacity * std::exp(-0.5 * (u * u + v * v));
        if (raw < o.alpha_min) continue;
        const double alpha = std::min(raw, o.alpha_max);
        const double w = weight == ScoreWeight::alpha ? alpha : alpha * t;
        if (maps.channels() < 3 || maps.row(2, y)[x] > 0) {
          Sums& sum = sums[s.index];
          sum.first += w * double{maps.row(0, y)[x]};
          sum.second += w * double{maps.row(1, y)[x]};
          sum.contribution += alpha * t;
          sum.pixels += 1;
        }
        t *= 1 - alpha;
      }
    }
  return sums;
}

class Score : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Score, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

TEST_P(Score, EqualsBruteForceInFloat64) {
  for (const bool masked : {false, true}) {
    const SplatCloud cloud = test::random_cloud(300, 1, 21, 0.8f, 0.08f);
    const Camera camera = test::camera_at({1.0, -0.7, -2.4}, {0, 0, 0}, 93, 71);
    const RenderOptions options;
    PlanarImage maps(93, 71, masked ? 3 : 2);
    for (int y = 0; y < 71; ++y)
      for (int x = 0; x < 93; ++x) {
        maps.row(0, y)[x] = (x / 7 + y / 5) % 2 ? 1.0f : 0.0f;
        maps.row(1, y)[x] = 0.01f * static_cast<float>(x);
        if (masked) maps.row(2, y)[x] = x * x + y * y > 60 * 60 ? 0.0f : 1.0f;
      }
    const Threads threads(2);
    Profiler times;
    const auto rasterizer =
        make_cpu_rasterizer(threads, times, {.isa = GetParam(), .count_pixel_pairs = false});
    rasterizer->forward(to_parameters(cloud, 1), camera, options);
    for (const ScoreWeight weight : {ScoreWeight::alpha, ScoreWeight::alpha_transmittance}) {
      const PlanarFloats& fast = rasterizer->score(maps, weight);
      const std::vector<Sums> exact = reference_scores(cloud, camera, options, maps, weight);
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        // A pixel at the very edge of a splat may be in or out
        const double slack = 2 * options.alpha_min + 1e-4 * exact[i].pixels;
        ASSERT_NEAR(fast.row(score::first)[i], exact[i].first, slack) << i;
        ASSERT_NEAR(fast.row(score::second)[i], exact[i].second, slack) << i;
        ASSERT_NEAR(fast.row(score::contribution)[i], exact[i].contribution, slack) << i;
        ASSERT_NEAR(fast.row(score::pixels)[i], exact[i].pixels, 2) << i;
      }
    }
  }
}

TEST(SplatScores, ViewsAddUpAndSharesAreMeansOverPixels) {
  const SplatCloud cloud = test::random_cloud(50, 0, 9, 0.5f, 0.1f);
  const PlanarFloats parameters = to_parameters(cloud, 0);
  std::vector<View> views;
  for (const glm::dvec3& eye : {glm::dvec3(0, 0, -3), glm::dvec3(2, 0, -2)}) {
    View view{test::camera_at(eye, {0, 0, 0}, 48, 40), {}, {}};
    view.rgb = Image<std::uint8_t>(48, 40, 3);
    views.push_back(view);
  }
  const Threads threads(2);
  Profiler times;
  const auto rasterizer = make_cpu_rasterizer(threads, times);
  ScoreOptions options;
  const auto scores = [&](const std::vector<std::uint32_t>& sampled, ScoreNormalization by) {
    options.normalization = by;
    return score_splats(views, sampled, parameters, {}, options, 0.2, *rasterizer, threads);
  };
  const SplatScores a = scores({0}, ScoreNormalization::sum),
                    b = scores({1}, ScoreNormalization::sum),
                    both = scores({0, 1}, ScoreNormalization::sum),
                    means = scores({0, 1}, ScoreNormalization::pixel);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_FLOAT_EQ(both.plus[i], a.plus[i] + b.plus[i]);
    EXPECT_FLOAT_EQ(both.contribution[i], a.contribution[i] + b.contribution[i]);
    EXPECT_FLOAT_EQ(means.plus[i], both.plus[i] / std::max(both.pixels[i], 1.0f));
    EXPECT_LE(means.plus[i], 1.0f);  // α ≤ 1 in bad pixels
  }
}

/// Two splats side by side before two cameras; a mask covers the left one in both.
struct MaskedPair {
  SplatCloud cloud;
  std::vector<View> views;
  MaskedPair() {
    cloud.resize(2);
    cloud.positions = {{-0.5f, 0, 0}, {0.5f, 0, 0}};
    for (auto& s : cloud.log_scales) s = glm::vec3(std::log(0.05f));
    for (float& o : cloud.opacity_logits) o = 2;
    for (const glm::dvec3& eye : {glm::dvec3(0, 0, -3), glm::dvec3(0, 0.3, -3)}) {
      View view{test::camera_at(eye, {0, 0, 0}, 48, 40), {}, {}};
      view.rgb = Image<std::uint8_t>(48, 40, 3);
      for (auto& v : view.rgb.pixels) v = 200;
      view.used = Image<std::uint8_t>(48, 40, 1);
      const bool first_is_left =
          (view.camera.rotation * glm::dvec3(cloud.positions[0]) + view.camera.translation).x < 0;
      for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 48; ++x) *view.used.at(x, y) = (x < 24) == first_is_left ? 0 : 255;
      views.push_back(std::move(view));
    }
  }
};

TEST(SplatScores, MaskedPixelsAddNothing) {
  const MaskedPair pair;
  const Threads threads(2);
  Profiler times;
  const auto rasterizer = make_cpu_rasterizer(threads, times);
  const SplatScores scores = score_splats(pair.views, {0, 1}, to_parameters(pair.cloud, 0), {}, {},
                                          0.2, *rasterizer, threads);
  EXPECT_EQ(scores.plus[0], 0);
  EXPECT_EQ(scores.pixels[0], 0);
  EXPECT_EQ(scores.contribution[0], 0);
  EXPECT_GT(scores.plus[1], 0);
  EXPECT_GT(scores.pixels[1], 4);
}

TEST(SplatScores, LossIsTheRootMeanSquareOverPixelsThatCount) {
  MaskedPair pair;
  const Threads threads(2);
  Profiler times;
  const auto rasterizer = make_cpu_rasterizer(threads, times);
  const PlanarFloats parameters = to_parameters(pair.cloud, 0);
  const auto loss_of = [&] {
    return score_splats(pair.views, {0, 1}, parameters, {}, {}, 0, *rasterizer, threads).loss;
  };
  double squares = 0, pixels = 0;
  for (const View& view : pair.views) {
    rasterizer->forward(parameters, view.camera, {});
    for (int y = 0; y < view.rgb.height; ++y)
      for (int x = 0; x < view.rgb.width; ++x) {
        if (*view.used.at(x, y) == 0) continue;
        double loss = 0;
        for (int c = 0; c < 3; ++c)
          loss += std::abs(double{rasterizer->color().row(c, y)[x]} -
                           static_cast<double>(view.rgb.at(x, y)[c]) / 255.0) /
                  3;
        squares += loss * loss;
        ++pixels;
      }
  }
  EXPECT_GT(loss_of(), 0);
  EXPECT_NEAR(loss_of(), std::sqrt(squares / pixels), 1e-6);
}

TEST(MaskPruning, SplatsThatAreSeenBehindMasksOnlyGo) {
  MaskedPair pair;
  const Threads threads(2);
  Profiler times;
  const auto rasterizer = make_cpu_rasterizer(threads, times);
  const auto actions = [&] {
    return masked_splats(pair.views, to_parameters(pair.cloud, 0), {}, *rasterizer);
  };
  EXPECT_EQ(actions(), (std::vector{RefineAction::prune, RefineAction::keep}));
  pair.cloud.positions[0] = {-30, 0, -5};
  EXPECT_EQ(actions()[0], RefineAction::keep) << "no view sees it";
  pair.cloud.positions[0] = {-0.5f, 0, 0};
  pair.views[1].used = {};
  EXPECT_EQ(actions()[0], RefineAction::keep) << "one view shows it without a mask";
}

TEST(MaskPruning, TakesPlaceForMaskedViewsOnly) {
  MaskedPair pair;
  EXPECT_NE(make_mask_pruning({}, pair.views), nullptr);
  for (View& view : pair.views) view.used = {};
  EXPECT_EQ(make_mask_pruning({}, pair.views), nullptr);
}

}  // namespace
}  // namespace fluxgs
