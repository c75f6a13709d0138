// Options that have no effect in a run, and that a user is told of.
#include <algorithm>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/fluxgs/options/ineffective_options.h"
#include "trainer/compress/compression.h"
#include "trainer/compress/sh_reduction.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/late_pruning.h"
#include "trainer/train/progressive_resolution.h"
#include "trainer/train/schedule.h"

namespace fluxgs::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Names = std::set<std::string>;

std::vector<std::string> said(const Names& given, const std::string& name,
                              const std::function<void(TrainOptions&)>& change = {}) {
  TrainOptions options = preset(name).value();
  if (change) change(options);
  return ineffective_options(given, options);
}

/// Those that have no effect in a preset.
Names ineffective_in(const std::string& name) {
  Names ineffective;
  TrainOptions options = preset(name).value();
  for (const OptionField& field : options.fields())
    if (!said({field.name}, name).empty()) ineffective.insert(field.name);
  return ineffective;
}

TEST(IneffectiveOptions, OfThePresets) {
  const Names of_energy = {"residual", "psi",        "psi-fit-iterations",
                           "psi-lr",   "quadrature", "samples"};
  const Names of_mcmc = {"mcmc-growth", "mcmc-noise"};  // no preset uses it
  const Names of_antialiasing = {"dilation", "min-variance"};
  const Names of_late = {"late-prune-from",    "late-prune-interval", "late-prune-until",
                         "late-prune-opacity", "late-prune-share",    "late-prune-views",
                         "densify-worth"};
  const Names of_scores = {"score-views", "camera-sampling",     "score-weight", "score-loss",
                           "score-unit",  "score-normalization", "azimuth-bins", "elevation-bins"};
  const auto all = [](std::initializer_list<Names> parts) {
    Names names;
    for (const Names& part : parts) names.insert(part.begin(), part.end());
    return names;
  };
  EXPECT_EQ(
      ineffective_in("flux"),
      all({of_energy,
           of_mcmc,
           {"phi-lr", "densify-size", "split-shrink", "quantile-minus", "tau-minus",
            "late-prune-opacity", "opacity-reset-to", "prune-world-size", "prune-screen-radius"}}));
  EXPECT_EQ(ineffective_in("flux-paper"),
            all({of_mcmc,
                 of_antialiasing,
                 of_late,
                 {"sh-max-psnr-drop", "resolution-until", "growth-rank", "cooldown-to"}}));
  const Names vanilla =
      all({of_energy,
           of_mcmc,
           of_antialiasing,
           of_late,
           of_scores,
           {"sh-max-psnr-drop", "phi-lr", "resolution-until", "growth-rank", "densify-loss",
            "quantile-plus", "tau-plus", "quantile-minus", "tau-minus", "cooldown-to"}});
  EXPECT_EQ(ineffective_in("3dgs-sh1"), vanilla);
  EXPECT_EQ(ineffective_in("3dgs"), all({vanilla, {"sh-reduce", "sh-reduce-iter"}}));
}

TEST(IneffectiveOptions, AreNamedWithWhatTheyNeed) {
  EXPECT_THAT(
      said({"psi", "residual"}, "flux"),
      ElementsAre("--residual, --psi have no effect, expected --sh-target 1 --sh-reduce energy"));
  EXPECT_THAT(
      said({"opacity-reset-interval"}, "3dgs",
           [](auto& o) { o.template get<DensificationOptions>().strategy = Densify::mcmc; }),
      ElementsAre(HasSubstr("--opacity-reset-interval")));
  EXPECT_THAT(
      said({"prune-opacity"}, "3dgs",
           [](auto& o) { o.template get<DensificationOptions>().strategy = Densify::mcmc; }),
      IsEmpty());
  EXPECT_THAT(said({"densify-gradient"}, "flux", [](auto& o) { o.target_splats = 100; }),
              ElementsAre(HasSubstr("without --target-splats")));
  EXPECT_THAT(said({"prune-world-size"}, "3dgs", [](auto& o) { o.iterations = 6000; }),
              ElementsAre(HasSubstr("--opacity-reset-interval below")));
  EXPECT_THAT(
      said({"sh-reduce"}, "3dgs",
           [](auto& o) { o.template get<ShReductionOptions>().reduce = ShReduction::none; }),
      IsEmpty());
  TrainOptions options = preset("3dgs").value();
  options.compact_output = false;
  EXPECT_THAT(ineffective_options({"max-psnr-drop"}, options),
              ElementsAre(HasSubstr("--max-psnr-drop")));
}

TEST(IneffectiveOptions, PhasesThatNeverTakePlace) {
  EXPECT_THAT(said({"densify-from"}, "flux",
                   [](auto& o) {
                     o.template get<DensificationOptions>().from = 50,
                                o.template get<DensificationOptions>().until = 10;
                   }),
              ElementsAre(HasSubstr("densification never takes place")));
  // The multiples of 350 begin behind 300
  const auto between = [](auto& o) {
    o.iterations = 600, o.template get<DensificationOptions>().from = 50,
    o.template get<DensificationOptions>().interval = 350;
  };
  EXPECT_THAT(
      said({"densify-interval"}, "3dgs", between),
      ElementsAre(
          "densification never takes place: it would be due every 350 iterations from 50 to 300"));
  EXPECT_THAT(said({"late-prune-from"}, "flux",
                   [](auto& o) {
                     o.template get<LatePruningOptions>().from = 50,
                                o.template get<LatePruningOptions>().until = 10;
                   }),
              ElementsAre(HasSubstr("late pruning never takes place")));
  EXPECT_THAT(
      said({"resolution-until"}, "flux",
           [](auto& o) { o.template get<ProgressiveResolutionOptions>().until = o.iterations; }),
      ElementsAre(HasSubstr("images stay halved to the end")));
  for (const std::string& name : preset_names())  // nothing of it was asked for
    EXPECT_THAT(said({"iterations"}, name, [](auto& o) { o.iterations = 3; }), IsEmpty());
}

}  // namespace
}  // namespace fluxgs::cli
