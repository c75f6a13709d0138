// A tiny capture and short runs on it, for tests of the training loop.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <stdexcept>
#include <utility>

#include "support/temp_folder.h"
#include "tools/capture/capture.h"
#include "trainer/train/trainer.h"

namespace fluxgs::test {

/// A capture of the analytic scene, made once.
inline const Dataset& small_capture() {
  static const Dataset data = [] {
    const TempFolder folder;
    capture::CaptureOptions options;
    options.width = 80, options.height = 60, options.train = 16, options.test = 3,
    options.samples = 2;
    if (auto made = capture::write_capture(folder.path(), options); !made)
      throw std::runtime_error(made.error().message());
    auto loaded = load_dataset(folder.path(), {});
    if (!loaded) throw std::runtime_error(loaded.error().message());
    return std::move(*loaded);
  }();
  return data;
}

/// Every eighth of the points, so that many runs take little time.
inline PointCloud points_of(const Dataset& data) {
  const auto points = initial_points(data, 1, Threads(2));
  if (!points) throw std::runtime_error(points.error().message());
  PointCloud few;
  few.source = points->source;
  for (std::size_t i = 0; i < points->positions.size(); i += 8) {
    few.positions.push_back(points->positions[i]);
    few.colors.push_back(points->colors[i]);
  }
  return few;
}

inline TrainOptions short_run(int iterations) {
  TrainOptions options;
  options.iterations = iterations;
  options.densify_from = 20;
  options.densify_interval = 20;
  options.densify_until = iterations;
  options.sh_degree_interval = 30;
  options.opacity_reset_interval = 70;
  options.max_splats = 12000;
  return options;
}

/// Every part of the method at work within a hundred steps.
inline TrainOptions everything() {
  TrainOptions options = short_run(100);
  options.densify = Densify::multiview;
  options.growth_rank = GrowthRank::error;
  options.split = Split::long_axis;
  options.prune = Prune::multiview;
  options.densify_until = 60;
  options.opacity_reset_interval = 30;  // twice, after which sizes are limited, too
  options.dropout = 2;
  options.sh_degree_interval = 10;
  options.sh_target = ShTarget::adaptive;
  options.switch_iteration = 65;
  options.late_prune = LatePrune::contribution;
  options.late_prune_from = 70;
  options.late_prune_interval = 5;
  options.late_prune_until = 80;
  options.rounding = Switch::on;
  options.round_from = 85;
  return options;
}

inline TrainOptions mcmc_run(int iterations) {
  TrainOptions options = short_run(iterations);
  options.densify = Densify::mcmc;
  options.opacity_reset_interval = 0;
  options.opacity_weight = options.scale_weight = 0.01;
  return options;
}

inline TrainState train(const Dataset& data, const TrainOptions& options, TrainState state,
                        int threads, int steps) {
  const Threads pool(threads);
  StageTimes times;
  Trainer trainer(data, options, std::move(state), pool, times);
  for (int i = 0; i < steps && !trainer.done(); ++i) trainer.step();
  return trainer.state();
}

inline TrainState fresh(const Dataset& data, const TrainOptions& options) {
  const Threads threads(2);
  return initial_state(data, points_of(data), options, threads);
}

inline void expect_same(const PlanarFloats& a, const PlanarFloats& b, const char* what) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.size(), b.size()) << what;
  for (int r = 0; r < a.rows(); ++r)
    ASSERT_EQ(0, std::memcmp(a.row(r), b.row(r), a.size() * sizeof(float)))
        << what << ", row " << r;
}

inline void expect_same(const TrainState& a, const TrainState& b) {
  expect_same(a.parameters, b.parameters, "parameters");
  expect_same(a.adam.first, b.adam.first, "first moments");
  expect_same(a.adam.second, b.adam.second, "second moments");
  expect_same(a.statistics, b.statistics, "statistics");
  EXPECT_EQ(a.degrees, b.degrees);
  EXPECT_EQ(a.switched_at, b.switched_at);
  ASSERT_EQ(a.networks.has_value(), b.networks.has_value());
  if (a.networks) {
    expect_same(a.networks->latents, b.networks->latents, "latents");
    expect_same(a.networks->adam.first, b.networks->adam.first, "first moments of latents");
    expect_same(a.networks->adam.second, b.networks->adam.second, "moments of latents");
    EXPECT_EQ(to_floats(a.networks->model), to_floats(b.networks->model));
  }
  ASSERT_EQ(a.rounding.has_value(), b.rounding.has_value());
  if (a.rounding) {
    const CompactSteps &s = a.rounding->steps, &t = b.rounding->steps;
    EXPECT_EQ(s.position, t.position);
    for (float CompactSteps::* step :
         {&CompactSteps::log_scale, &CompactSteps::rotation, &CompactSteps::opacity,
          &CompactSteps::sh_dc, &CompactSteps::sh_rest, &CompactSteps::energy})
      EXPECT_EQ(s.*step, t.*step);
    EXPECT_EQ(a.rounding->costs.weights, b.rounding->costs.weights);
    EXPECT_EQ(a.rounding->costs.sh_factors, b.rounding->costs.sh_factors);
    EXPECT_EQ(a.rounding->costs.scale, b.rounding->costs.scale);
    EXPECT_EQ(a.rounding->costs.rotation, b.rounding->costs.rotation);
    expect_same(a.rounding->offsets, b.rounding->offsets, "rounding");
  }
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.max_pairs, b.max_pairs);
  EXPECT_EQ(a.random, b.random);
  EXPECT_EQ(a.view_order, b.view_order);
  EXPECT_EQ(a.next_view, b.next_view);
}

}  // namespace fluxgs::test
