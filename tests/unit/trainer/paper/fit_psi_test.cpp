// Ψ learns given colours before its first image.
#include "trainer/paper/fit_psi.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support.h"
#include "trainer/paper/appearance_pass.h"

namespace fluxgs {
namespace {

using test::AppearanceScene;
using test::kSh;

/// Colours that follow from E and the position.
PlanarFloats learnable(const AppearanceScene& scene) {
  PlanarFloats target(kSh, scene.parameters.size());
  for (int k = 0; k < kSh; ++k)
    for (std::size_t i = 0; i < target.size(); ++i)
      target.row(k)[i] = 0.5f * scene.latents.row(k)[i] +
                         0.1f * scene.latents.row((k + 5) % kSh)[i] +
                         0.1f * scene.parameters.row(row::position)[i];
  return target;
}

TEST(FitPsi, LearnsWhatFollowsFromItsInputs) {
  AppearanceScene scene(4000, true, true);
  const PlanarFloats target = learnable(scene), latents = scene.latents;
  const std::vector<float> phi = to_floats(*scene.model.phi);
  const PsiFitReport report = fit_psi(scene.model, scene.parameters, scene.latents, target,
                                      {.steps = 400, .batch = 1000, .latent_rate = 0}, Threads(2));
  RecordProperty("rms", std::to_string(report.rms_after));
  EXPECT_GT(report.rms_before, 0.3);
  EXPECT_LT(report.rms_after, 0.02);
  EXPECT_EQ(scene.model.psi->steps, 0);
  EXPECT_EQ(scene.model.psi->first[0].row(0)[0], 0);
  EXPECT_EQ(to_floats(*scene.model.phi), phi);
  for (int k = 0; k < kSh; ++k)
    for (std::size_t i = 0; i < latents.size(); ++i)
      ASSERT_EQ(latents.row(k)[i], scene.latents.row(k)[i]);

  // The reported error is that of the colours
  scene.model.phi.reset();
  PlanarFloats colors(row::count(1), latents.size());
  bake(scene.model, scene.parameters, scene.latents, Threads(1), colors);
  double squares = 0;
  for (int k = 0; k < kSh; ++k)
    for (std::size_t i = 0; i < latents.size(); ++i)
      squares += std::pow(double{colors.row(row::sh_dc + k)[i]} - double{target.row(k)[i]}, 2);
  EXPECT_NEAR(std::sqrt(squares / (12.0 * 4000)), report.rms_after, 1e-9);
}

// Colours that have nothing to do with the inputs can only be stored in E
TEST(FitPsi, MovesTheLatentsToo) {
  AppearanceScene fixed(2000, true, false);
  AppearanceScene free = fixed;
  PlanarFloats target(kSh, 2000);
  for (int k = 0; k < kSh; ++k)
    std::copy_n(fixed.gradient.row(row::sh_dc + k), 2000, target.row(k));
  PsiFitOptions options{.steps = 300, .batch = 2000, .latent_rate = 0};
  const double without =
      fit_psi(fixed.model, fixed.parameters, fixed.latents, target, options, Threads(2)).rms_after;
  options.latent_rate = 0.02;
  const double with =
      fit_psi(free.model, free.parameters, free.latents, target, options, Threads(2)).rms_after;
  RecordProperty("without", std::to_string(without));
  RecordProperty("with", std::to_string(with));
  EXPECT_GT(without, 0.3);
  EXPECT_LT(with, 0.2 * without);
}

TEST(FitPsi, TheSameForAnyNumberOfThreads) {
  std::vector<float> models[2];
  for (const int threads : {1, 3}) {
    AppearanceScene scene(3000, true, false);
    const PlanarFloats target = learnable(scene);
    fit_psi(scene.model, scene.parameters, scene.latents, target,
            {.steps = 5, .batch = 2500, .latent_rate = 0.01}, Threads(threads));
    models[threads / 2] = to_floats(scene.model);
    for (int k = 0; k < kSh; ++k)
      models[threads / 2].insert(models[threads / 2].end(), scene.latents.row(k),
                                 scene.latents.row(k) + 3000);
  }
  EXPECT_EQ(models[0], models[1]);
}

TEST(FitPsi, LeavesBadSplatsOut) {
  AppearanceScene scene(300, true, false);
  PlanarFloats target = learnable(scene);
  target.row(3)[5] = std::nanf("");
  scene.latents.row(0)[6] = std::nanf("");
  scene.parameters.row(row::position + 1)[7] = std::nanf("");
  const PsiFitReport report =
      fit_psi(scene.model, scene.parameters, scene.latents, target, {.steps = 200}, Threads(1));
  EXPECT_LT(report.rms_after, 0.1);
  AppearanceScene none(300, false, true), empty(0, true, true);
  EXPECT_EQ(fit_psi(none.model, none.parameters, none.latents, target, {}, Threads(1)).rms_after,
            0);
  EXPECT_EQ(fit_psi(empty.model, empty.parameters, empty.latents, {}, {}, Threads(1)).rms_after, 0);
}

}  // namespace
}  // namespace fluxgs
