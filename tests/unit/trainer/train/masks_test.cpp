// Trainings with masks: what they ignore leaves no trace, what they carve stays empty.
#include "short_run.h"

#include <algorithm>
#include <array>

#include "support/scenes.h"
#include "trainer/loss/photometric.h"
#include "trainer/raster/view_renderer.h"
#include "trainer/train/carving.h"
#include "trainer/train/evaluate.h"

namespace fluxgs::test {
namespace {

/// A run that is long enough for a picture.
TrainOptions picture_run() {
  TrainOptions options = short_run(400);
  options.get<OpacityResetOptions>().interval = 0;
  options.get<DensificationOptions>().until = 250;
  return options;
}

/// The trained scene after all iterations.
SplatCloud trained(const Dataset& data, const PointCloud& points, const TrainOptions& options) {
  const Threads threads(2);
  Profiler times;
  Trainer trainer(data, options, initial_state(data, points, options, threads), threads, times);
  while (!trainer.done()) trainer.step();
  return trainer.cloud();
}

/// The small capture with somebody in a loud shirt in each photo, at another place each time, and
/// masks that cover them with a margin.
Dataset with_occluder(Dataset data) {
  for (std::size_t i = 0; i < data.train.size(); ++i) {
    Image<std::uint8_t>& rgb = data.train[i].rgb;
    Image<std::uint8_t>& used = data.train[i].used;
    used = Image<std::uint8_t>(rgb.width, rgb.height, 1);
    const int x0 = 5 + static_cast<int>(13 * i) % 45, y0 = 15 + static_cast<int>(7 * i) % 20;
    for (int y = 0; y < rgb.height; ++y)
      for (int x = 0; x < rgb.width; ++x) {
        const int u = x - x0, v = y - y0;
        *used.at(x, y) = u >= -2 && u < 20 && v >= -2 && v < 27 ? 0 : 255;
        if (u < 0 || u >= 18 || v < 0 || v >= 25) continue;
        for (int c = 0; c < 3; ++c)
          rgb.at(x, y)[c] = static_cast<std::uint8_t>((u / 3 + v / 3) % 2 ? 250 : 60 * c);
      }
  }
  return data;
}

TEST(Masks, WhatTheyCoverDoesNotMatter) {
  const TrainOptions options = short_run(60);
  const PointCloud points = points_of(small_capture());
  const Dataset masked = with_occluder(small_capture());
  Dataset other = masked;
  for (std::size_t i = 0; i < other.train.size(); ++i) {
    other.train[i].rgb = small_capture().train[i].rgb;
    other.train[i].used = masked.train[i].used;
  }
  const SplatCloud a = trained(masked, points, options), b = trained(other, points, options);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.opacity_logits, b.opacity_logits);
  EXPECT_EQ(a.sh_dc, b.sh_dc);
}

TEST(Masks, WhiteOnesChangeNothing) {
  const TrainOptions options = short_run(60);
  const PointCloud points = points_of(small_capture());
  Dataset white = small_capture();
  for (View& view : white.train) {
    view.used = Image<std::uint8_t>(view.rgb.width, view.rgb.height, 1);
    std::ranges::fill(view.used.pixels, std::uint8_t{255});
  }
  EXPECT_EQ(trained(white, points, options).positions,
            trained(small_capture(), points, options).positions);
}

constexpr int kSize = 48;

/// A ball of black and some white splats before nothing, from around, with transparency.
Dataset black_ball() {
  SplatCloud ball = random_cloud(400, 0, 5, 0.4f, 0.08f);
  for (std::size_t i = 0; i < ball.size(); ++i) {
    ball.opacity_logits[i] = 4;
    ball.sh_dc[i] = glm::vec3(i % 20 == 0 ? 1.7f : -1.8f);  // white or black
  }
  const Threads threads(2);
  RenderOptions white;
  white.background = glm::dvec3(1);
  const ViewRenderer over_black = cpu_view_renderer(ball, {}, threads),
                     over_white = cpu_view_renderer(ball, white, threads);
  const auto byte = [](float v) {
    return static_cast<std::uint8_t>(255 * std::clamp(v, 0.0f, 1.0f) + 0.5f);
  };
  Dataset data;
  for (int i = 0; i < 18; ++i) {
    const double turn = 0.7 * i, height = 0.5 * (i % 3 - 1);
    View view{camera_at({2 * std::cos(turn), height, 2 * std::sin(turn)}, {0, 0, 0}, kSize, kSize),
              {},
              {}};
    view.rgb = Image<std::uint8_t>(kSize, kSize, 3);
    view.alpha = Image<std::uint8_t>(kSize, kSize, 1);
    const PlanarImage dark = *over_black(view.camera), light = *over_white(view.camera);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        for (int c = 0; c < 3; ++c) view.rgb.at(x, y)[c] = byte(dark.row(c, y)[x]);
        *view.alpha.at(x, y) = byte(1 - (light.row(1, y)[x] - dark.row(1, y)[x]));
      }
    (i % 6 == 5 ? data.test : data.train).push_back(std::move(view));
  }
  return data;
}

/// The test views over another background.
std::vector<View> over(std::vector<View> views, float background) {
  for (View& view : views)
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x)
        for (int c = 0; c < 3; ++c) {
          const float added = background * static_cast<float>(255 - *view.alpha.at(x, y));
          view.rgb.at(x, y)[c] = static_cast<std::uint8_t>(
              std::min(255.0f, static_cast<float>(view.rgb.at(x, y)[c]) + added));
        }
  return views;
}

TEST(Carving, ABlackBallIsWholeAndWhatIsTransparentIsEmpty) {
  const Dataset carved = black_ball();
  Dataset plain = carved;
  for (View& view : plain.train) view.alpha = {};
  PointCloud points = random_points(carved.train, 3000, 3);
  const TrainOptions options = picture_run();
  const std::vector<View> white = over(carved.test, 1);
  const Threads threads(2);
  RenderOptions on_white;
  on_white.background = glm::dvec3(1);
  const auto score = [&](const Dataset& data) {
    const SplatCloud cloud = trained(data, points, options);
    return evaluate(white, cpu_view_renderer(cloud, on_white, threads), threads)->psnr;
  };
  const double with = score(carved), without = score(plain);
  RecordProperty("with", std::to_string(with));
  RecordProperty("without", std::to_string(without));
  EXPECT_GT(with, without + 6);
  EXPECT_GT(with, 19);
}

TEST(Carving, TakesPlaceForTransparentViewsOnly) {
  Dataset data = black_ball();
  EXPECT_NE(make_carving({}, data.train), nullptr);
  EXPECT_EQ(make_carving({}, small_capture().train), nullptr);

  // Photos without transparency keep the run's own background
  data.train[0].alpha = {};
  const PointCloud points = random_points(data.train, 300, 3);
  TrainOptions options = short_run(40);
  options.render.background = glm::dvec3(0.25);
  const Threads threads(2);
  Profiler times;
  Trainer trainer(data, options, initial_state(data, points, options, threads), threads, times);
  int opaque = 0;
  std::vector<glm::dvec3> backgrounds;
  for (int i = 0; i < 30; ++i) {
    trainer.step();
    if (trainer.view == &data.train[0]) {
      EXPECT_EQ(trainer.render.background, glm::dvec3(0.25));
      ++opaque;
    } else {
      EXPECT_EQ(std::ranges::count(backgrounds, trainer.render.background), 0);
      backgrounds.push_back(trainer.render.background);
    }
  }
  EXPECT_GE(opaque, 2);
  EXPECT_GT(backgrounds.size(), 20U);
}

TEST(Carving, TheLossOfOpacitiesPullsTowardsThePhoto) {
  Image<std::uint8_t> alpha(4, 1, 1), used(4, 1, 1);
  alpha.pixels = {0, 255, 51, 0};
  used.pixels = {1, 1, 1, 0};
  PlanarImage transmittance(4, 1, 1), gradient;
  std::ranges::copy(std::array{0.9f, 0.3f, 0.8f, 0.5f}, transmittance.row(0, 0));
  alpha_loss_gradient(transmittance, alpha, used, 0.4, Threads(2), gradient);
  const float* g = gradient.row(0, 0);
  EXPECT_FLOAT_EQ(g[0], -0.1f);  // less opaque: more transmittance lowers the loss
  EXPECT_FLOAT_EQ(g[1], 0.1f);
  EXPECT_EQ(g[2], 0);  // as it should be
  EXPECT_EQ(g[3], 0);  // does not count
}

}  // namespace
}  // namespace fluxgs::test
