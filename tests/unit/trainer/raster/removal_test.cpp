// The change of the squared error that the removal of a splat makes, against the float64 reference.
#include <gtest/gtest.h>

#include <cmath>

#include "fluxgs/image.h"
#include "support/scenes.h"
#include "tools/reference/reference_renderer.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

constexpr int kWidth = 53, kHeight = 38;

/// Rays that end early would see less than the rasterizer counts with.
RenderOptions to_the_end() {
  RenderOptions options;
  options.background = {0.3, 0.1, 0.6};
  options.transmittance_min = 1e-12;
  return options;
}

/// Splats of which some hide others.
SplatCloud crowd(std::uint32_t seed) {
  SplatCloud cloud = test::random_cloud(70, 1, seed, 0.7F, 0.12F);
  for (std::size_t i = 0; i < cloud.size(); i += 4) cloud.opacity_logits[i] = 6;  // beyond α_max
  return cloud;
}

Camera view() { return test::camera_at({1.0, -0.7, -2.4}, {0, 0, 0}, kWidth, kHeight); }

/// The mask: true for pixels that count.
bool counts(int x, int y) { return (x / 5 + y / 3) % 3 != 0; }

double squared_error(const SplatCloud& cloud, const Image<double>& target, bool masked) {
  const Image<double> color = render_reference(cloud, view(), to_the_end()).color;
  double sum = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        if (!masked || counts(x, y)) sum += std::pow(color.at(x, y)[c] - target.at(x, y)[c], 2);
  return sum;
}

SplatCloud without(const SplatCloud& cloud, std::uint32_t splat) {
  std::vector<std::uint32_t> others;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (i != splat) others.push_back(i);
  return in_order(cloud, others);
}

PlanarImage planes_with_mask(const Image<double>& target, bool masked) {
  PlanarImage planes(kWidth, kHeight, masked ? 4 : 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) planes.row(c, y)[x] = static_cast<float>(target.at(x, y)[c]);
      if (masked) planes.row(3, y)[x] = counts(x, y) ? 1.0F : 0.0F;
    }
  return planes;
}

class Removal : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Removal, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

TEST_P(Removal, ChangesTheErrorAsRenderingAgainDoes) {
  const SplatCloud cloud = crowd(5);
  const Image<double> target = render_reference(crowd(6), view(), to_the_end()).color;
  const Threads threads(1);
  Profiler times;
  const auto rasterizer =
      make_cpu_rasterizer(threads, times, {.isa = GetParam(), .count_pixel_pairs = false});
  for (const bool masked : {false, true}) {
    rasterizer->forward(to_parameters(cloud, cloud.sh_degree), view(), to_the_end());
    const PlanarFloats& found = rasterizer->removal(planes_with_mask(target, masked));
    const double before = squared_error(cloud, target, masked);
    int seen = 0;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      const double change = squared_error(without(cloud, i), target, masked) - before;
      EXPECT_NEAR(found.row(removal::change)[i], change, 1e-3 * std::abs(change) + 1e-4) << i;
      EXPECT_EQ(found.row(removal::pixels)[i] > 0, change != 0) << i;
      seen += change != 0 ? 1 : 0;
    }
    EXPECT_GT(seen, 50);
  }
}

}  // namespace
}  // namespace fluxgs
