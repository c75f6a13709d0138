// What the trainer's networks make of a scene is what a phone makes of its file.
#include "trainer/paper/export_networks.h"

#include <gtest/gtest.h>

#include <cmath>

#include <fmt/format.h>

#include "fluxgs/io/gltf.h"
#include "support.h"
#include "support/needs_onnxruntime.h"
#include "trainer/paper/appearance_pass.h"

namespace fluxgs {
namespace {

using test::AppearanceScene;
using test::kSh;

constexpr std::pair<bool, bool> kNetworks[] = {{true, true}, {true, false}, {false, true}};

PlanarFloats baked(const AppearanceScene& scene) {
  PlanarFloats colors(row::count(1), scene.parameters.size());
  bake(scene.model, scene.parameters, scene.latents, Threads(2), colors);
  return colors;
}

double difference(const SplatCloud& cloud, std::size_t of, const PlanarFloats& colors,
                  std::size_t i) {
  double worst = 0;
  for (int k = 0; k < kSh; ++k) {
    const glm::vec3& rgb =
        k < 3 ? cloud.sh_dc[of] : cloud.sh_rest[3 * of + static_cast<std::size_t>(k / 3 - 1)];
    worst = std::max(worst, std::abs(double{rgb[k % 3]} - double{colors.row(row::sh_dc + k)[i]}));
  }
  return worst;
}

TEST(ExportNetworks, OnnxruntimeMakesTheSameColours) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  for (const auto& [psi, phi] : kNetworks) {
    const AppearanceScene scene(3000, psi, phi);
    const auto stored = export_networks(scene.model, scene.latents);
    ASSERT_TRUE(stored) << stored.error().message();
    EXPECT_EQ(stored->energy.size(), psi ? 12 * scene.latents.size() : 0);
    SplatCloud cloud = cloud_for_networks(scene.model, scene.parameters, scene.latents);
    turn_gltf_frame(cloud);
    const auto done = networks::bake_appearance(cloud, stored->energy, stored->models,
                                                stored->normalisation, "scene");
    ASSERT_TRUE(done) << done.error().message();
    turn_gltf_frame(cloud);
    const PlanarFloats colors = baked(scene);
    double worst = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      worst = std::max(worst, difference(cloud, i, colors, i));
    RecordProperty(std::string("worst") + (psi ? "_psi" : "") + (phi ? "_phi" : ""),
                   fmt::format("{:.2g}", worst));
    EXPECT_LT(worst, 1e-5);
  }
}

TEST(ExportNetworks, ACompactFileMakesTheSameColours) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  for (const auto& [psi, phi] : kNetworks) {
    const AppearanceScene scene(500, psi, phi);
    auto stored = export_networks(scene.model, scene.latents);
    ASSERT_TRUE(stored) << stored.error().message();
    const SplatCloud cloud = cloud_for_networks(scene.model, scene.parameters, scene.latents);
    const CompactOptions options{.steps = {.position = 1e-5,
                                           .log_scale = 1e-4f,
                                           .rotation = 1e-4f,
                                           .opacity = 1e-4f,
                                           .sh_dc = 1e-4f,
                                           .sh_rest = 1e-4f,
                                           .energy = 1e-4f},
                                 .rate_weight = 0,
                                 .networks = std::move(*stored)};
    const auto file = encode_compact_glb(cloud, options, "net.glb");
    ASSERT_TRUE(file) << file.error().message();
    const auto read = read_glb(*file, "net.glb");
    ASSERT_TRUE(read) << read.error().message();
    const PlanarFloats colors = baked(scene);
    const auto order = compact_order(cloud, options);
    ASSERT_EQ(read->cloud.size(), order.size());
    double squares = 0;
    for (std::size_t k = 0; k < order.size(); ++k)
      squares += std::pow(difference(read->cloud, k, colors, order[k]), 2);
    EXPECT_LT(std::sqrt(squares / 500), 5e-3);  // rounding of the file's attributes
  }
}

TEST(ExportNetworks, WeightsThatAreNotFiniteAreRefused) {
  AppearanceScene scene(5, true, true);
  scene.model.phi->weights[1].row(2)[3] = std::nanf("");
  const auto stored = export_networks(scene.model, scene.latents);
  ASSERT_FALSE(stored);
  EXPECT_EQ(stored.error().message(), "network phi: network: layer 1: a weight is not finite");
}

}  // namespace
}  // namespace fluxgs
