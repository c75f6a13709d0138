// Options by name, presets, and the schedule that they make.
#include "trainer/train/schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "trainer/compress/compression.h"
#include "trainer/compress/sh_reduction.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/late_pruning.h"
#include "trainer/densify/opacity_reset.h"
#include "trainer/densify/splat_scores.h"
#include "trainer/paper/network_colors.h"
#include "trainer/train/sh_curriculum.h"

namespace fluxgs {
namespace {

TEST(Options, PresetsAreValidAndUnknownOnesNamed) {
  EXPECT_EQ(preset_names(), (std::vector<std::string>{"flux", "flux-paper", "3dgs", "3dgs-sh1"}));
  for (const std::string& name : preset_names()) {
    const auto options = preset(name);
    ASSERT_TRUE(options) << name;
    EXPECT_TRUE(options->validate()) << name;
    EXPECT_EQ(options->depth_spread, RenderOptions().depth_spread_max)
        << name << ": else its scenes are shown otherwise than they were trained";
  }
  const auto unknown = preset("4dgs");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message().find("3dgs-sh1"), std::string::npos);
}

TrainOptions resolved(const TrainOptions& options) { return plan_schedule(options).options; }

OptionField* find(OptionFields& fields, const std::string& name) {
  const auto at = std::ranges::find_if(fields, [&](const auto& f) { return name == f.name; });
  return at == fields.end() ? nullptr : &*at;
}

/// Default options with one set as on the command line.
TrainOptions with(const std::string& name, std::string_view text) {
  TrainOptions options = default_options();
  OptionFields fields = options.fields();
  EXPECT_TRUE(set(*find(fields, name), text)) << name << " " << text;
  return options;
}

TEST(Schedule, ScalesLearnFasterInShortRuns) {
  TrainOptions options = preset("flux").value();
  const auto rate = [&](int iterations) {
    options.iterations = iterations;
    return resolved(options).scale_lr;
  };
  EXPECT_EQ(rate(2000), 0.02);
  EXPECT_NEAR(rate(7000), 0.02, 1e-12);
  EXPECT_NEAR(rate(14000), 0.01, 1e-12);
  EXPECT_EQ(rate(45000), 0.005);
  options.scale_lr = 0.003;
  EXPECT_EQ(rate(7000), 0.003);
  EXPECT_EQ(resolved(preset("3dgs").value()).scale_lr, 0.005);
}

TEST(Options, ChoicesHaveTheirNames) {
  const auto reduction = [](const char* name, const char* text) {
    return with(name, text).get<ShReductionOptions>();
  };
  EXPECT_EQ(reduction("sh-target", "0").target, ShTarget::degree_0);
  EXPECT_EQ(reduction("sh-target", "2").target, ShTarget::degree_2);
  EXPECT_EQ(reduction("sh-target", "adaptive").target, ShTarget::adaptive);
  EXPECT_EQ(reduction("sh-reduce", "view-ls").reduce, ShReduction::view_ls);
  EXPECT_EQ(reduction("sh-reduce", "truncate").reduce, ShReduction::truncate);
  EXPECT_EQ(reduction("sh-reduce", "uniform-ls").reduce, ShReduction::uniform_ls);
  EXPECT_EQ(reduction("sh-reduce", "energy").reduce, ShReduction::energy);
  EXPECT_EQ(reduction("sh-reduce", "none").reduce, ShReduction::none);
  EXPECT_EQ(reduction("quadrature", "lebedev").quadrature, Quadrature::lebedev);
  EXPECT_EQ(reduction("quadrature", "mc").quadrature, Quadrature::mc);
  const auto networks = [](const char* name, const char* text) {
    return with(name, text).get<NetworkColorOptions>();
  };
  EXPECT_EQ(networks("residual", "3-2").residual, Residual::from_2);
  EXPECT_EQ(networks("residual", "3-0").residual, Residual::from_0);
  EXPECT_FALSE(networks("psi", "off").psi);
  EXPECT_TRUE(networks("phi", "on").phi);
  const auto densification = [](const char* name, const char* text) {
    return with(name, text).get<DensificationOptions>();
  };
  EXPECT_EQ(densification("densify", "gradient").strategy, Densify::gradient);
  EXPECT_EQ(densification("densify", "multiview").strategy, Densify::multiview);
  EXPECT_EQ(densification("densify", "mcmc").strategy, Densify::mcmc);
  EXPECT_EQ(densification("split", "long-axis").split, Split::long_axis);
  EXPECT_EQ(densification("growth-rank", "error").growth_rank, GrowthRank::error);
  EXPECT_EQ(densification("prune", "none").prune, Prune::none);
  EXPECT_EQ(densification("prune", "multiview").prune, Prune::multiview);
  const auto scores = [](const char* name, const char* text) {
    return with(name, text).get<ScoreOptions>();
  };
  EXPECT_EQ(scores("camera-sampling", "random").sampling, CameraSampling::random);
  EXPECT_EQ(scores("score-weight", "alpha-t").weight, ScoreWeight::alpha_transmittance);
  EXPECT_EQ(scores("score-unit", "raw").unit, ScoreUnit::raw);
  EXPECT_EQ(scores("score-normalization", "sum").normalization, ScoreNormalization::sum);
  const auto late = [](const char* name, const char* text) {
    return with(name, text).get<LatePruningOptions>();
  };
  EXPECT_EQ(late("late-prune", "opacity").mode, LatePrune::opacity);
  EXPECT_EQ(late("late-prune", "contribution").mode, LatePrune::contribution);
}

// Whatever an option is set to by its text is what its text then says.
TEST(Options, TextsComeBack) {
  TrainOptions options = default_options();
  OptionFields fields = options.fields();
  std::set<std::string> names;
  for (OptionField& f : fields) {
    EXPECT_TRUE(names.insert(f.name).second) << f.name << " is there twice";
    const std::string text = text_of(f);
    EXPECT_TRUE(set(f, text)) << f.name << " " << text;
    EXPECT_EQ(text_of(f), text) << f.name;
    EXPECT_FALSE(f.group.empty()) << f.name;
  }
  EXPECT_GT(names.size(), 70u);
}

TEST(Options, WrongTextsAreRefusedByName) {
  const struct {
    const char *name, *text, *expected;
  } cases[] = {{"iterations", "0", "1 to 1000000000"},
               {"iterations", "2.5", "a whole number"},
               {"iterations", "", "a whole number"},
               {"iterations", "1e12", "a whole number"},
               {"seed", "-1", "0 to 2^64 - 1"},
               {"opacity-lr", "nan", "0 to 10"},
               {"opacity-lr", "0.1x", "0 to 10"},
               {"densify", "grad", "multiview, gradient, mcmc"},
               {"phi", "true", "off or on"}};
  TrainOptions options = default_options();
  OptionFields fields = options.fields();
  for (const auto& [name, text, expected] : cases) {
    const auto result = set(*find(fields, name), text);
    ASSERT_FALSE(result) << name << " " << text;
    EXPECT_THAT(result.error().message(), testing::HasSubstr(std::string("--") + name));
    EXPECT_THAT(result.error().message(), testing::HasSubstr(expected));
  }
}

// Fields of a copy are bound to the copy.
TEST(Options, CopiesAreTheirOwn) {
  TrainOptions first = default_options();
  TrainOptions second = first;
  OptionFields fields = second.fields();
  ASSERT_TRUE(set(*find(fields, "late-prune"), "opacity"));
  ASSERT_TRUE(set(*find(fields, "iterations"), "7"));
  EXPECT_EQ(first.get<LatePruningOptions>().mode, LatePrune::off);
  EXPECT_EQ(first.iterations, 30000);
  first = second;
  EXPECT_EQ(first.get<LatePruningOptions>().mode, LatePrune::opacity);
  EXPECT_EQ(first.iterations, 7);
}

std::vector<std::string> phases_of(const TrainOptions& options) {
  std::vector<std::string> names;
  const Schedule schedule = plan_schedule(options);
  for (const auto& phase : schedule.phases) names.emplace_back(phase->name());
  return names;
}

TEST(Schedule, HasThePhasesOfThePresetsInTheirOrder) {
  using testing::ElementsAre;
  EXPECT_THAT(phases_of(preset("3dgs").value()),
              ElementsAre("SH curriculum", "densification", "opacity reset"));
  EXPECT_THAT(phases_of(preset("3dgs-sh1").value()),
              ElementsAre("SH curriculum", "SH reduction", "densification", "opacity reset"));
  EXPECT_THAT(phases_of(preset("flux").value()),
              ElementsAre("progressive resolution", "SH curriculum", "dropout", "SH reduction",
                          "densification", "late pruning", "camera clearance", "anti-aliasing"));
  EXPECT_THAT(phases_of(preset("flux-paper").value()),
              ElementsAre("SH curriculum", "energy moments", "SH reduction", "network colours",
                          "densification", "opacity reset"));
}

TEST(Schedule, PlansSayWhenAndWhat) {
  const std::string plan = plan_table(plan_schedule(preset("flux").value()));
  EXPECT_THAT(plan, testing::ContainsRegex("21000 +once +SH reduction"));
  EXPECT_THAT(plan, testing::ContainsRegex("6000-18000 +3000 +late pruning"));
  EXPECT_THAT(plan_table(plan_schedule(preset("3dgs").value())),
              testing::ContainsRegex("3000-12000 +3000 +opacity reset"));
  TrainOptions never = preset("3dgs-sh1").value();
  never.get<ShReductionOptions>().iteration = 40000;
  EXPECT_THAT(plan_table(plan_schedule(never)),
              testing::ContainsRegex("never +once +SH reduction"));
}

TEST(Schedule, RowsAreDueAtTheMultiplesOfTheirInterval) {
  const Period row{.from = 50, .until = 300, .interval = 100};
  EXPECT_EQ(row.first(), 100);
  for (const int due : {100, 200, 300}) EXPECT_TRUE(row.due(due));
  for (const int idle : {0, 50, 150, 400}) EXPECT_FALSE(row.due(idle));
  EXPECT_TRUE(row.takes_place(100));
  EXPECT_FALSE(row.takes_place(99));
  EXPECT_FALSE((Period{.from = 50, .until = 90, .interval = 100}.takes_place(1000)));
  EXPECT_TRUE((Period{.from = 50, .until = 50, .interval = 0}.due(50)));
}

TEST(Options, RulesThatDoNotExistAreRefused) {
  TrainOptions options = preset("flux-paper").value();
  options.get<ShReductionOptions>().quadrature =
      Quadrature::lebedev;  // with the paper's 2,048 directions
  const auto valid = options.validate();
  ASSERT_FALSE(valid);
  EXPECT_NE(valid.error().message().find("--samples"), std::string::npos);
  options.get<ShReductionOptions>().samples = 302;
  EXPECT_TRUE(options.validate());
}

TEST(Options, WhatDependsOnTheLengthFollowsIt) {
  TrainOptions options;
  options.iterations = 2000;
  const TrainOptions short_run = resolved(options);
  EXPECT_EQ(short_run.get<DensificationOptions>().until, 1000);
  EXPECT_EQ(short_run.get<ShCurriculumOptions>().interval, 251);
  options.get<ShReductionOptions>().target = ShTarget::degree_1;
  EXPECT_EQ(resolved(options).get<ShReductionOptions>().iteration, 200);
  EXPECT_EQ(resolved(options).get<ShCurriculumOptions>().interval,
            50);  // degree 3 for a quarter of these 200
  options.iterations = 30000;
  EXPECT_EQ(resolved(options).get<ShReductionOptions>().iteration, 3000);  // as in the paper
  options.get<ShReductionOptions>().target = ShTarget::adaptive;
  EXPECT_EQ(resolved(options).get<ShReductionOptions>().iteration, 21000);
}

TEST(Options, WhatEndsWithTheRunFollowsItsLength) {
  for (const int iterations : {600, 3000, 7000, 30000}) {
    TrainOptions flux = preset("flux").value();
    flux.iterations = iterations;
    const TrainOptions o = resolved(flux);
    EXPECT_LT(o.get<DensificationOptions>().until, o.get<ShReductionOptions>().iteration);
    EXPECT_LT(o.get<ShReductionOptions>().iteration, iterations);
    EXPECT_GE(o.get<DensificationOptions>().interval, 50);
  }
}

TEST(Options, LatePruningByContributionDoesNotWaitForTheLastDensification) {
  TrainOptions o;
  o.get<LatePruningOptions>().mode = LatePrune::opacity;
  // At 18, 21, 24 and 27 thousand, as in the design of the paper
  EXPECT_EQ(resolved(o).get<LatePruningOptions>().from, 18000);
  EXPECT_EQ(resolved(o).get<LatePruningOptions>().until, 27000);
  EXPECT_EQ(resolved(o).get<LatePruningOptions>().interval, 3000);
  o.get<LatePruningOptions>().mode = LatePrune::contribution;
  EXPECT_EQ(resolved(o).get<LatePruningOptions>().from, 6000);
  EXPECT_EQ(resolved(o).get<LatePruningOptions>().interval, 3000);
  EXPECT_EQ(resolved(o).get<LatePruningOptions>().until, 20000);
}

TEST(Options, OpacitiesAreResetWhileSplatsAreAdded) {
  TrainOptions o = preset("3dgs").value();
  for (const auto& [iterations, resets] : {std::pair(6000, false), {7000, true}, {30000, true}}) {
    o.iterations = iterations;
    EXPECT_EQ(resets_opacity(resolved(o)), resets) << iterations;
  }
  EXPECT_FALSE(resets_opacity(resolved(preset("flux").value())));
}

TEST(Options, PartsThatNeedEachOtherAreCheckedByName) {
  const auto refused = [](const TrainOptions& o, const char* name) {
    const auto valid = o.validate();
    return !valid && valid.error().message().find(name) != std::string::npos;
  };
  TrainOptions o;
  o.get<NetworkColorOptions>().phi = true;
  EXPECT_TRUE(refused(o, "--phi"));
  o.get<ShReductionOptions>().target = ShTarget::degree_1;
  EXPECT_TRUE(o.validate());
  o.sh_degree = 0;
  EXPECT_TRUE(refused(o, "--phi"));
  o = {};
  o.get<ShReductionOptions>().reduce = ShReduction::energy;
  EXPECT_TRUE(refused(o, "--sh-reduce"));
  o = {};
  o.get<ShReductionOptions>().target = ShTarget::adaptive;
  o.get<ShReductionOptions>().reduce = ShReduction::truncate;
  EXPECT_TRUE(refused(o, "--sh-target"));
}

TEST(Options, RangesAreCheckedByName) {
  TrainOptions options;
  EXPECT_TRUE(options.validate());
  options.lambda_dssim = 1.5;
  const auto result = options.validate();
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message().find("--lambda-dssim: 1.5 is out of range, expected 0 to 1"),
            std::string::npos);
  options.lambda_dssim = std::nan("");
  EXPECT_FALSE(options.validate());
  EXPECT_FALSE(preset("no-such"));
  EXPECT_TRUE(preset("3dgs"));
}

}  // namespace
}  // namespace fluxgs
