// Options that others make ineffective, and that a user is told of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/fluxgs/idle_options.h"

namespace fluxgs::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> said(const std::set<std::string>& given, const char* name,
                              const std::function<void(TrainOptions&)>& change = {}) {
  TrainOptions options = preset(name).value();
  if (change) change(options);
  return idle_options(given, options);
}

TEST(IdleOptions, NothingIsSaidOfWhatWorks) {
  for (const std::string& name : preset_names()) EXPECT_THAT(said({}, name.c_str()), IsEmpty());
  EXPECT_THAT(said({"sh-loss", "densify-gradient", "quantile-plus", "late-prune-share", "cameras",
                    "coarse-until", "round-from", "switch-iter"},
                   "flux"),
              IsEmpty());
  EXPECT_THAT(said({"quadrature", "samples", "residual", "psi-rate", "phi-rate", "quantile-minus",
                    "tau-minus", "azimuth-bins"},
                   "flux-paper"),
              IsEmpty());
  EXPECT_THAT(said({"sh-reduce"}, "3dgs", [](auto& o) { o.sh_reduce = ShReduction::none; }),
              IsEmpty());
}

TEST(IdleOptions, WhatDoesNothingIsNamedWithWhatItNeeds) {
  EXPECT_THAT(
      said({"psi", "residual"}, "flux"),
      ElementsAre("no effect of --residual, --psi, expected --sh-target 1 --sh-reduce energy"));
  EXPECT_THAT(said({"sh-reduce"}, "3dgs"), ElementsAre(HasSubstr("--sh-reduce")));
  EXPECT_THAT(said({"late-prune-share"}, "3dgs"), ElementsAre(HasSubstr("contribution")));
  EXPECT_THAT(said({"opacity-reset-interval"}, "3dgs", [](auto& o) { o.densify = Densify::mcmc; }),
              ElementsAre(HasSubstr("--opacity-reset-interval")));
  EXPECT_THAT(said({"mcmc-growth"}, "3dgs"), ElementsAre(HasSubstr("--densify mcmc")));
  EXPECT_THAT(said({"sh-target"}, "3dgs", [](auto& o) { o.sh_degree = 1; }),
              ElementsAre(HasSubstr("end at degree 1")));
}

TEST(IdleOptions, StagesThatBeginBehindTheirEnd) {
  const auto late = [](auto& o) { o.densify_from = 50, o.densify_until = 10; };
  EXPECT_THAT(said({"densify-from"}, "flux", late),
              ElementsAre(HasSubstr("begin at step 50 and ends at step 10")));
  EXPECT_THAT(said({"late-prune-from"}, "flux",
                   [](auto& o) { o.late_prune_from = 50, o.late_prune_until = 10; }),
              ElementsAre(HasSubstr("no late pruning")));
  EXPECT_THAT(said({"coarse-until"}, "flux", [](auto& o) { o.coarse_until = o.iterations; }),
              ElementsAre(HasSubstr("halved to the end")));
}

}  // namespace
}  // namespace fluxgs::cli
