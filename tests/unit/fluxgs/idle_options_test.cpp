// Options that others make ineffective, and that a user is told of.
#include <algorithm>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/fluxgs/idle_options.h"

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
  return idle_options(given, options, true);
}

/// Those that do nothing in a preset.
Names idle_in(const std::string& name) {
  Names idle;
  for (const OptionField& field : option_fields())
    if (!said({field.name}, name).empty()) idle.insert(field.name);
  return idle;
}

TEST(IdleOptions, AreOptions) {
  for (const std::string& name : options_that_may_be_idle())
    EXPECT_TRUE(std::ranges::any_of(option_fields(), [&](const auto& f) { return name == f.name; }))
        << name;
}

TEST(IdleOptions, OfThePresets) {
  const Names of_energy = {"residual", "psi", "psi-fit-steps", "psi-rate", "quadrature", "samples"};
  const Names of_mcmc = {"mcmc-growth", "mcmc-noise"};
  const Names of_late = {"late-prune-from", "late-prune-interval", "late-prune-until",
                         "late-prune-opacity", "late-prune-share"};
  const Names of_scores = {"cameras",    "camera-sampling", "score",        "score-loss",
                           "score-unit", "score-share",     "azimuth-bins", "elevation-bins"};
  const Names of_rounding = {"round-from", "round-interval"};
  const auto all = [](std::initializer_list<Names> parts) {
    Names names;
    for (const Names& part : parts) names.insert(part.begin(), part.end());
    return names;
  };
  EXPECT_EQ(idle_in("flux"), all({of_energy,
                                  of_mcmc,
                                  {"phi-rate", "densify-size", "split-shrink", "quantile-minus",
                                   "tau-minus", "late-prune-opacity"}}));
  EXPECT_EQ(idle_in("flux-paper"),
            all({of_mcmc, of_late, of_rounding, {"sh-loss", "coarse-until", "growth-rank"}}));
  const Names vanilla = all({of_energy,
                             of_mcmc,
                             of_late,
                             of_scores,
                             of_rounding,
                             {"sh-loss", "phi-rate", "coarse-until", "growth-rank", "quantile-plus",
                              "tau-plus", "quantile-minus", "tau-minus"}});
  EXPECT_EQ(idle_in("3dgs-sh1"), vanilla);
  EXPECT_EQ(idle_in("3dgs"), all({vanilla, {"sh-reduce", "switch-iter"}}));
}

TEST(IdleOptions, AreNamedWithWhatTheyNeed) {
  EXPECT_THAT(
      said({"psi", "residual"}, "flux"),
      ElementsAre("no effect of --residual, --psi, expected --sh-target 1 --sh-reduce energy"));
  EXPECT_THAT(said({"opacity-reset-interval"}, "3dgs", [](auto& o) { o.densify = Densify::mcmc; }),
              ElementsAre(HasSubstr("--opacity-reset-interval")));
  EXPECT_THAT(said({"prune-opacity"}, "3dgs", [](auto& o) { o.densify = Densify::mcmc; }),
              IsEmpty());
  EXPECT_THAT(said({"densify-gradient"}, "flux", [](auto& o) { o.target_splats = 100; }),
              ElementsAre(HasSubstr("without --target-splats")));
  EXPECT_THAT(said({"prune-world-size"}, "3dgs", [](auto& o) { o.iterations = 6000; }),
              ElementsAre(HasSubstr("--opacity-reset-interval below")));
  EXPECT_THAT(said({"sh-reduce"}, "3dgs", [](auto& o) { o.sh_reduce = ShReduction::none; }),
              IsEmpty());
  EXPECT_THAT(said({"sh-target"}, "3dgs", [](auto& o) { o.sh_degree = 1; }),
              ElementsAre(HasSubstr("end at degree 1")));
  TrainOptions options = preset("3dgs").value();
  EXPECT_THAT(idle_options({"store-loss"}, options, false), ElementsAre(HasSubstr("--store-loss")));
  options.rounding = Switch::on;
  EXPECT_THAT(idle_options({"store-loss"}, options, false), IsEmpty());
}

TEST(IdleOptions, StagesThatNeverHappen) {
  EXPECT_THAT(
      said({"densify-from"}, "flux", [](auto& o) { o.densify_from = 50, o.densify_until = 10; }),
      ElementsAre(HasSubstr("no splats are added")));
  // The multiples of 350 begin behind 300
  const auto between = [](auto& o) {
    o.iterations = 600, o.densify_from = 50, o.densify_interval = 350;
  };
  EXPECT_THAT(said({"densify-interval"}, "3dgs", between),
              ElementsAre("no splats are added: that would be every 350 steps from 50 to 300"));
  EXPECT_THAT(said({"late-prune-from"}, "flux",
                   [](auto& o) { o.late_prune_from = 50, o.late_prune_until = 10; }),
              ElementsAre(HasSubstr("no late pruning")));
  EXPECT_THAT(said({"coarse-until"}, "flux", [](auto& o) { o.coarse_until = o.iterations; }),
              ElementsAre(HasSubstr("halved to the end")));
  for (const std::string& name : preset_names())  // nothing of it was asked for
    EXPECT_THAT(said({"iterations"}, name, [](auto& o) { o.iterations = 3; }), IsEmpty());
}

}  // namespace
}  // namespace fluxgs::cli
