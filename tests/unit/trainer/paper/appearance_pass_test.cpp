// Colours from networks while they are trained: values and derivatives against float64, threads and
// instruction sets, bad numbers, checkpoints, and that training gets somewhere.
#include "trainer/paper/appearance_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "support.h"
#include "trainer/paper/latent_adam.h"

namespace fluxgs {
namespace {

using test::AppearanceScene;
using test::exact_colors;
using test::kSh;

struct Case {
  bool psi, phi;
  Isa isa;
};
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Isa isa : available_isas())
    for (const auto& [psi, phi] :
         {std::pair(true, true), std::pair(true, false), std::pair(false, true)})
      all.push_back({psi, phi, isa});
  return all;
}
class Appearance : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Appearance, testing::ValuesIn(cases()), [](const auto& c) {
  return std::string(name_of(c.param.isa)) + (c.param.psi ? "_psi" : "") +
         (c.param.phi ? "_phi" : "");
});

constexpr AdamConstants kAdam{0.9, 0.999, 1e-15};

TEST_P(Appearance, ShadesAsInFloat64AndOnlyTheListedSplats) {
  const AppearanceScene scene(300, GetParam().psi, GetParam().phi);
  const std::vector<std::uint32_t> listed = scene.every(3);
  const Threads threads(2);
  AppearancePass pass(threads, GetParam().isa);
  PlanarFloats colors = scene.parameters;
  pass.shade(scene.model, scene.parameters, scene.latents, listed, colors);
  for (std::size_t i = 0; i < scene.parameters.size(); ++i) {
    const auto expected = exact_colors(scene, i);
    for (int k = 0; k < kSh; ++k) {
      const float c = colors.row(row::sh_dc + k)[i];
      if (i % 3 == 0)
        ASSERT_NEAR(c, expected[static_cast<std::size_t>(k)], 1e-5) << "splat " << i << ' ' << k;
      else
        ASSERT_EQ(c, scene.parameters.row(row::sh_dc + k)[i]);
    }
  }
  for (int r = 0; r < row::sh_dc; ++r)
    for (std::size_t i = 0; i < colors.size(); ++i)
      ASSERT_EQ(colors.row(r)[i], scene.parameters.row(r)[i]);

  PlanarFloats baked(row::count(1), scene.parameters.size());
  bake(scene.model, scene.parameters, scene.latents, threads, baked, GetParam().isa);
  for (const std::uint32_t i : listed)
    for (int k = 0; k < kSh; ++k)
      ASSERT_EQ(baked.row(row::sh_dc + k)[i], colors.row(row::sh_dc + k)[i]);
}

TEST(Appearance, WithoutNetworksTheLatentsAreTheColours) {
  const AppearanceScene scene(10, false, false);
  const Threads threads(1);
  AppearancePass pass(threads);
  PlanarFloats colors = scene.parameters, back(kSh, 10);
  pass.shade(scene.model, scene.parameters, scene.latents, scene.every(1), colors);
  pass.backpropagate(scene.model, scene.gradient, scene.visible, back);
  for (int k = 0; k < kSh; ++k)
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_EQ(colors.row(row::sh_dc + k)[i], scene.latents.row(k)[i]);
      EXPECT_EQ(back.row(k)[i], scene.gradient.row(row::sh_dc + k)[i]);
    }
}

/// L = Σ gradient · c over the splats, with c in float64.
double loss(const AppearanceScene& scene, const std::vector<std::uint32_t>& splats) {
  double sum = 0;
  for (const std::uint32_t i : splats) {
    const auto c = exact_colors(scene, i);
    for (int k = 0; k < kSh; ++k)
      sum += c[static_cast<std::size_t>(k)] * double{scene.gradient.row(row::sh_dc + k)[i]};
  }
  return sum;
}

TEST_P(Appearance, GradientsAreThoseOfCentralDifferences) {
  AppearanceScene scene(60, GetParam().psi, GetParam().phi);
  const std::vector<std::uint32_t> listed = scene.every(2);
  const Threads threads(2);
  AppearancePass pass(threads, GetParam().isa);
  PlanarFloats colors = scene.parameters, latent_gradient(kSh, 60);
  pass.shade(scene.model, scene.parameters, scene.latents, listed, colors);
  pass.backpropagate(scene.model, scene.gradient, scene.visible, latent_gradient);
  EXPECT_EQ(pass.rejected_gradients(), 0u);

  const auto slope = [&](float& value, float step) {
    const float own = value, up = own + step, down = own - step;
    value = up;
    const double above = loss(scene, listed);
    value = down;
    const double below = loss(scene, listed);
    value = own;
    return (above - below) / (double{up} - double{down});
  };
  for (int k = 0; k < kSh; ++k)
    for (const std::size_t i : {0u, 16u, 58u})
      EXPECT_NEAR(latent_gradient.row(k)[i], slope(scene.latents.row(k)[i], 1e-3f), 5e-3)
          << "latent " << k << " of splat " << i;
  EXPECT_EQ(latent_gradient.row(0)[1], 0);  // not listed

  // The weights' gradients, read off the first step: Adam's first step has the gradient's sign and
  // its first moment is a tenth of it
  AppearanceModel stepped = scene.model;
  pass.step(stepped, {}, kAdam);
  Random random(5);
  const auto check = [&](std::optional<TrainableMlp>& own,
                         const std::optional<TrainableMlp>& after) {
    if (!own) return;
    for (std::size_t l = 0; l < own->layers(); ++l)
      for (int n = 0; n < 8; ++n) {
        PlanarFloats& w = own->weights[l];
        const int r = static_cast<int>(uniform(random) * w.rows());
        const auto c = static_cast<std::size_t>(uniform(random) * static_cast<double>(w.size()));
        EXPECT_NEAR(10 * after->first[l].row(r)[c], slope(w.row(r)[c], 1e-4f), 2e-2)
            << "layer " << l << ", weight " << r << ' ' << c;
      }
  };
  check(scene.model.psi, stepped.psi);
  check(scene.model.phi, stepped.phi);
}

// Many splats are worked on in groups, whose sums are added
TEST(Appearance, WeightGradientsAreSumsOverTheSplats) {
  const AppearanceScene scene(3500, true, true);
  const Threads threads(2);
  const auto first_moments = [&](std::span<const std::uint32_t> splats) {
    AppearanceModel model = scene.model;
    AppearancePass pass(threads);
    PlanarFloats colors(row::count(1), 3500), back(kSh, 3500);
    pass.shade(model, scene.parameters, scene.latents, scene.every(2), colors);  // leaves its sums
    pass.backpropagate(model, scene.gradient, scene.visible, back);
    pass.shade(model, scene.parameters, scene.latents, splats, colors);
    pass.backpropagate(model, scene.gradient, scene.visible, back);
    pass.step(model, {}, kAdam);
    return std::pair(std::move(model.psi->first), std::move(model.phi->first));
  };
  const std::vector<std::uint32_t> all = scene.every(1);
  const auto whole = first_moments(all);
  const auto head = first_moments(std::span(all).first(700)),
             middle = first_moments(std::span(all).subspan(700, 900)),
             tail = first_moments(std::span(all).subspan(1600));
  const auto compare = [](const MlpMatrices& sum, const MlpMatrices& a, const MlpMatrices& b,
                          const MlpMatrices& c) {
    for (std::size_t l = 0; l < sum.size(); ++l)
      for (int r = 0; r < sum[l].rows(); ++r)
        for (std::size_t k = 0; k < sum[l].size(); ++k)
          ASSERT_NEAR(sum[l].row(r)[k], a[l].row(r)[k] + b[l].row(r)[k] + c[l].row(r)[k], 2e-3);
  };
  compare(whole.first, head.first, middle.first, tail.first);
  compare(whole.second, head.second, middle.second, tail.second);
  EXPECT_GT(std::abs(whole.second[3].row(32)[0]), 0.1f);
}

/// Some steps of training towards colours; what comes out.
struct Trained {
  std::vector<float> model;
  PlanarFloats latents, colors;
  double first_error = 0, last_error = 0;
};
Trained train(int threads, Isa isa, std::size_t splats, int steps, bool psi = true) {
  AppearanceScene scene(splats, psi, true);
  const Threads pool(threads);
  AppearancePass pass(pool, isa);
  Trained out{.model = {}, .latents = scene.latents, .colors = scene.parameters};
  const std::vector<std::uint32_t> listed = scene.every(1);
  PlanarFloats gradient(row::count(1), splats), latent_gradient(kSh, splats);
  AdamState adam{PlanarFloats(kSh, splats), PlanarFloats(kSh, splats)};
  for (int step = 1; step <= steps; ++step) {
    pass.shade(scene.model, scene.parameters, out.latents, listed, out.colors);
    double error = 0;
    for (int k = 0; k < kSh; ++k)
      for (std::size_t i = 0; i < splats; ++i) {
        // Colours that follow from the attributes
        const float target = 0.3f * scene.parameters.row(row::position + k % 3)[i] +
                             0.2f * scene.parameters.row(row::opacity)[i];
        const float d = out.colors.row(row::sh_dc + k)[i] - target;
        gradient.row(row::sh_dc + k)[i] = d / static_cast<float>(splats);
        error += double{d} * double{d} / (kSh * static_cast<double>(splats));
      }
    pass.backpropagate(scene.model, gradient, scene.visible, latent_gradient);
    pass.step(scene.model, {}, kAdam);
    latent_adam_step(out.latents, adam, latent_gradient, scene.visible, {1e-3, 1e-3},
                     AdamStep(kAdam, step, adam_kernels(isa)), pool);
    (step == 1 ? out.first_error : out.last_error) = std::sqrt(error);
  }
  out.model = to_floats(scene.model);
  return out;
}

TEST(Appearance, TheSameBytesForAnyNumberOfThreads) {
  const Trained one = train(1, best_isa(), 2500, 4);
  for (const int threads : {2, 3}) {
    const Trained other = train(threads, best_isa(), 2500, 4);
    EXPECT_EQ(one.model, other.model);
    for (int k = 0; k < kSh; ++k)
      for (std::size_t i = 0; i < 2500; ++i) {
        ASSERT_EQ(one.latents.row(k)[i], other.latents.row(k)[i]);
        ASSERT_EQ(one.colors.row(row::sh_dc + k)[i], other.colors.row(row::sh_dc + k)[i]);
      }
  }
}

TEST(Appearance, InstructionSetsAgree) {
  const Trained best = train(2, best_isa(), 500, 3);
  for (const Isa isa : available_isas()) {
    const Trained other = train(2, isa, 500, 3);
    for (int k = 0; k < kSh; ++k)
      for (std::size_t i = 0; i < 500; ++i)
        ASSERT_NEAR(best.colors.row(row::sh_dc + k)[i], other.colors.row(row::sh_dc + k)[i], 1e-4);
  }
}

TEST(Appearance, TrainingGetsSomewhere) {
  for (const bool psi : {false, true}) {
    const Trained t = train(2, best_isa(), 400, 300, psi);
    RecordProperty(psi ? "with_psi" : "without_psi", std::to_string(t.last_error));
    EXPECT_GT(t.first_error, 0.5);
    EXPECT_LT(t.last_error, 0.06);
  }
}

TEST(Appearance, BadNumbersAreSkippedAndCounted) {
  AppearanceScene clean(200, true, true);
  AppearanceScene dirty = clean;
  const float nan = std::nanf("");
  dirty.gradient.row(row::sh_dc)[7] = nan;
  dirty.gradient.row(row::sh_rest + 8)[9] = std::numeric_limits<float>::infinity();
  for (const std::size_t i : {7, 9})
    for (int k = 0; k < kSh; ++k) clean.gradient.row(row::sh_dc + k)[i] = 0;
  // Not visible: whatever is left there does not count
  dirty.gradient.row(row::sh_dc + 3)[11] = nan;
  dirty.visible[11] = clean.visible[11] = 0;
  const Threads threads(1);
  AppearancePass pass_clean(threads), pass_dirty(threads);
  PlanarFloats colors(row::count(1), 200), a(kSh, 200), b(kSh, 200);
  for (auto& [scene, pass, out] :
       {std::tie(clean, pass_clean, a), std::tie(dirty, pass_dirty, b)}) {
    pass.shade(scene.model, scene.parameters, scene.latents, scene.every(1), colors);
    pass.backpropagate(scene.model, scene.gradient, scene.visible, out);
    pass.step(scene.model, {}, kAdam);
  }
  EXPECT_EQ(pass_clean.rejected_gradients(), 0u);
  EXPECT_EQ(pass_dirty.rejected_gradients(), 2u);
  EXPECT_EQ(to_floats(clean.model), to_floats(dirty.model));
  for (int k = 0; k < kSh; ++k) {
    for (std::size_t i = 0; i < 200; ++i) ASSERT_EQ(a.row(k)[i], b.row(k)[i]);
    for (const std::size_t i : {7, 9, 11}) EXPECT_EQ(b.row(k)[i], 0);
  }
}

TEST(Appearance, ABadSplatDoesNoHarmToTheOthers) {
  for (const bool psi : {true, false}) {
    AppearanceScene scene(100, psi, true);
    const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
    scene.parameters.row(row::position)[3] = nan;
    scene.parameters.row(row::log_scale + 1)[4] = infinity;
    scene.parameters.row(row::rotation + 2)[5] = nan;
    for (int k = 0; k < 4; ++k) scene.parameters.row(row::rotation + k)[6] = 0;
    scene.parameters.row(row::opacity)[7] = -infinity;
    scene.latents.row(2)[8] = nan;
    scene.latents.row(7)[9] = 1e30f;
    const Threads threads(1);
    AppearancePass pass(threads);
    PlanarFloats colors(row::count(1), 100), back(kSh, 100);
    pass.shade(scene.model, scene.parameters, scene.latents, scene.every(1), colors);
    pass.backpropagate(scene.model, scene.gradient, scene.visible, back);
    pass.step(scene.model, {}, kAdam);
    for (const float v : to_floats(scene.model)) ASSERT_TRUE(std::isfinite(v));
    for (int k = 0; k < kSh; ++k)
      for (std::size_t i = 0; i < 100; ++i) {
        ASSERT_TRUE(std::isfinite(back.row(k)[i]));
        ASSERT_TRUE(i == 8 || std::isfinite(colors.row(row::sh_dc + k)[i]));
      }
  }
}

TEST(Appearance, LatentsBeyondTheLimitHaveNoGradientThroughTheNetworks) {
  AppearanceScene scene(20, true, false);
  scene.latents.row(4)[3] = 65;
  scene.latents.row(5)[3] = -64;
  const Threads threads(1);
  AppearancePass pass(threads);
  PlanarFloats colors(row::count(1), 20), back(kSh, 20);
  pass.shade(scene.model, scene.parameters, scene.latents, scene.every(1), colors);
  pass.backpropagate(scene.model, scene.gradient, scene.visible, back);
  EXPECT_EQ(back.row(4)[3], 0);
  EXPECT_EQ(back.row(5)[3], 0);
  EXPECT_NE(back.row(6)[3], 0);
}

TEST(Appearance, ModelsGoThroughAListOfFloats) {
  AppearanceScene scene(50, true, true);
  const Threads threads(1);
  AppearancePass pass(threads);
  PlanarFloats colors(row::count(1), 50), back(kSh, 50);
  const auto step = [&](AppearanceModel& model) {
    pass.shade(model, scene.parameters, scene.latents, scene.every(1), colors);
    pass.backpropagate(model, scene.gradient, scene.visible, back);
    pass.step(model, {}, kAdam);
  };
  step(scene.model);
  const std::vector<float> floats = to_floats(scene.model);
  auto again = model_from_floats(true, true, floats);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(to_floats(*again), floats);
  step(scene.model);
  step(*again);
  EXPECT_EQ(to_floats(*again), to_floats(scene.model));
  EXPECT_FALSE(model_from_floats(true, false, floats));
  std::vector<float> bad = floats;
  bad[2] = std::nanf("");
  EXPECT_FALSE(model_from_floats(true, true, bad));
}

TEST(Appearance, ASceneMayBeEmptyAndAViewToo) {
  AppearanceScene scene(0, true, true);
  const Threads threads(2);
  AppearancePass pass(threads);
  PlanarFloats colors(row::count(1), 0), back(kSh, 0);
  pass.shade(scene.model, scene.parameters, scene.latents, {}, colors);
  pass.backpropagate(scene.model, scene.gradient, scene.visible, back);
  const std::vector<float> before = to_floats(scene.model);
  pass.step(scene.model, {}, kAdam);
  const std::vector<float> after = to_floats(scene.model);
  ASSERT_EQ(before.size(), after.size());
  EXPECT_EQ(scene.model.psi->weights[0].row(0)[0], before[32]);  // steps, but does not move
  bake(scene.model, scene.parameters, scene.latents, threads, colors);
}

TEST(Appearance, RatesOfPsiWarmUpAndFall) {
  const NetworkRates rates;
  EXPECT_DOUBLE_EQ(rates.psi_at(0), 1e-4);
  EXPECT_DOUBLE_EQ(rates.psi_at(49), 5e-3);
  EXPECT_DOUBLE_EQ(rates.psi_at(99), 0.01);
  EXPECT_DOUBLE_EQ(rates.psi_at(999), 0.01);
  EXPECT_DOUBLE_EQ(rates.psi_at(1000), 0.0033);
  EXPECT_DOUBLE_EQ(rates.psi_at(3500), 0.01 * 0.33 * 0.33);
  EXPECT_DOUBLE_EQ(rates.psi_at(100000), 0.01 * std::pow(0.33, 3));
}

TEST(Appearance, PhiBeginsAsNothing) {
  AppearanceScene scene(50, false, false);
  scene.model = make_appearance_model(false, true, scene.model.normalisation, 3);
  PlanarFloats colors(row::count(1), 50);
  const Threads threads(1);
  bake(scene.model, scene.parameters, scene.latents, threads, colors);
  for (int k = 0; k < kSh; ++k)
    for (std::size_t i = 0; i < 50; ++i)
      ASSERT_EQ(colors.row(row::sh_dc + k)[i], scene.latents.row(k)[i]);
}

}  // namespace
}  // namespace fluxgs
