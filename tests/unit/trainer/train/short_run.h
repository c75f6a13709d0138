// A tiny capture and short runs on it, for tests of the training loop.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <stdexcept>
#include <utility>

#include "support/temp_folder.h"
#include "tools/capture/capture.h"
#include "trainer/compress/sh_reduction.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/dropout.h"
#include "trainer/densify/late_pruning.h"
#include "trainer/densify/opacity_reset.h"
#include "trainer/densify/penalties.h"
#include "trainer/paper/network_colors.h"
#include "trainer/train/progressive_resolution.h"
#include "trainer/train/sh_curriculum.h"
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
  options.get<DensificationOptions>().from = 20;
  options.get<DensificationOptions>().interval = 20;
  options.get<DensificationOptions>().until = iterations;
  options.get<ShCurriculumOptions>().interval = 30;
  options.get<OpacityResetOptions>().interval = 70;
  options.max_splats = 12000;
  return options;
}

/// Every part of the method at work within a hundred steps.
inline TrainOptions everything() {
  TrainOptions options = short_run(100);
  options.get<DensificationOptions>().strategy = Densify::multiview;
  options.get<DensificationOptions>().growth_rank = GrowthRank::error;
  options.get<DensificationOptions>().split = Split::long_axis;
  options.get<DensificationOptions>().prune = Prune::multiview;
  options.get<DensificationOptions>().until = 60;
  options.get<OpacityResetOptions>().interval = 30;  // twice, after which sizes are limited, too
  options.get<DropoutOptions>().dropout = 2;
  options.get<ShCurriculumOptions>().interval = 10;
  options.get<ShReductionOptions>().target = ShTarget::adaptive;
  options.get<ShReductionOptions>().iteration = 65;
  options.get<LatePruningOptions>().mode = LatePrune::contribution;
  options.get<LatePruningOptions>().from = 70;
  options.get<LatePruningOptions>().interval = 5;
  options.get<LatePruningOptions>().until = 80;
  return options;
}

inline TrainOptions mcmc_run(int iterations) {
  TrainOptions options = short_run(iterations);
  options.get<DensificationOptions>().strategy = Densify::mcmc;
  options.get<OpacityResetOptions>().interval = 0;
  options.get<PenaltyOptions>().opacity_weight = options.get<PenaltyOptions>().scale_weight = 0.01;
  return options;
}

inline TrainState train(const Dataset& data, const TrainOptions& options, TrainState state,
                        int threads, int steps) {
  const Threads pool(threads);
  Profiler times;
  Trainer trainer(data, options, std::move(state), pool, times);
  for (int i = 0; i < steps && !trainer.done(); ++i) trainer.step();
  return trainer.saved_state();
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
  ASSERT_EQ(a.attached.size(), b.attached.size());
  for (const auto& [name, values] : a.attached) {
    ASSERT_TRUE(b.attached.contains(name)) << name;
    expect_same(values.values, b.attached.at(name).values, name.c_str());
    EXPECT_EQ(values.moments, b.attached.at(name).moments) << name;
  }
  EXPECT_EQ(a.phase_values, b.phase_values);
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.max_pairs, b.max_pairs);
  EXPECT_EQ(a.splat_worth, b.splat_worth);
  EXPECT_EQ(a.random, b.random);
  EXPECT_EQ(a.view_order, b.view_order);
  EXPECT_EQ(a.next_view, b.next_view);
}

}  // namespace fluxgs::test
