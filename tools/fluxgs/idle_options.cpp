#include "tools/fluxgs/idle_options.h"

#include <algorithm>
#include <initializer_list>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fluxgs::cli {
namespace {

using O = TrainOptions;

bool reduces_by(const O& o, ShReduction how) { return reduces_appearance(o) && o.sh_reduce == how; }

bool has_moments(const O& o) { return reduces_by(o, ShReduction::energy); }

bool has_scores(const O& o) {
  return o.late_prune == LatePrune::opacity ||
         (o.densify != Densify::mcmc &&
          (o.densify == Densify::multiview || o.prune == Prune::multiview));
}

bool prunes_by_score(const O& o) {
  return o.late_prune == LatePrune::opacity ||
         (o.densify != Densify::mcmc && o.prune == Prune::multiview);
}

struct Rule {
  std::initializer_list<const char*> names;
  bool (*works)(const O&);
  const char* needed;
};

const Rule kRules[] = {
    {{"sh-reduce"},
     [](const O& o) { return reduces_appearance(o) || o.sh_reduce == ShReduction::none; },
     "a --sh-target below --sh-degree"},
    {{"switch-iter"}, reduces_appearance, "a --sh-target below --sh-degree"},
    {{"sh-loss"},
     [](const O& o) { return o.sh_target == ShTarget::adaptive; },
     "--sh-target adaptive"},
    {{"quadrature", "samples"},
     [](const O& o) { return has_moments(o) || reduces_by(o, ShReduction::uniform_ls); },
     "--sh-target 1 with --sh-reduce energy or uniform-ls"},
    {{"residual", "psi", "psi-fit-steps", "psi-rate"},
     has_moments,
     "--sh-target 1 --sh-reduce energy"},
    {{"phi-rate"}, [](const O& o) { return makes_phi(o); }, "--phi on"},
    {{"coarse-until"}, [](const O& o) { return o.coarse_levels > 0; }, "--coarse-levels"},
    {{"densify-gradient", "densify-size", "densify-growth", "growth-rank", "split", "prune",
      "prune-world-size", "prune-screen-radius", "opacity-reset-interval", "opacity-reset-to",
      "opacity-cap"},
     [](const O& o) { return o.densify != Densify::mcmc; },
     "--densify grad or multiview"},
    {{"split-shrink"},
     [](const O& o) { return o.densify != Densify::mcmc && o.split == Split::random; },
     "--split random without mcmc"},
    {{"mcmc-growth", "mcmc-noise"},
     [](const O& o) { return o.densify == Densify::mcmc; },
     "--densify mcmc"},
    {{"quantile-plus", "tau-plus"},
     [](const O& o) { return o.densify == Densify::multiview; },
     "--densify multiview"},
    {{"quantile-minus", "tau-minus"}, prunes_by_score, "--prune multiview or --late-prune opacity"},
    {{"cameras", "camera-sampling", "score", "score-loss", "score-unit", "score-share"},
     has_scores,
     "--densify multiview, --prune multiview or --late-prune opacity"},
    {{"azimuth-bins", "elevation-bins"},
     [](const O& o) { return has_scores(o) && o.camera_sampling == CameraSampling::stratified; },
     "scores of stratified cameras"},
    {{"late-prune-from", "late-prune-interval", "late-prune-until"},
     [](const O& o) { return o.late_prune != LatePrune::off; },
     "--late-prune"},
    {{"late-prune-opacity"},
     [](const O& o) { return o.late_prune == LatePrune::opacity; },
     "--late-prune opacity"},
    {{"late-prune-share"},
     [](const O& o) { return o.late_prune == LatePrune::contribution; },
     "--late-prune contribution"},
    {{"round-from", "round-interval"},
     [](const O& o) { return o.rounding == Switch::on; },
     "--rounding on and a .glb"},
};

/// Of --sh-target, whatever --sh-degree is.
int asked_degree(O o) {
  o.sh_degree = 3;
  return target_degree(o);
}

void add_stages(const std::set<std::string>& given, const O& o, std::vector<std::string>& lines) {
  // A short run without it is what most who ask for one want
  const bool asked = given.contains("densify-from") || given.contains("densify-until") ||
                     given.contains("target-splats");
  if (asked && o.densify_from > std::min(o.densify_until, o.iterations))
    lines.push_back(
        fmt::format("no splats are added: that would begin at step {} and ends at step {}",
                    o.densify_from, std::min(o.densify_until, o.iterations)));
  if (o.late_prune != LatePrune::off &&
      o.late_prune_from > std::min(o.late_prune_until, o.iterations))
    lines.push_back(
        fmt::format("there is no late pruning: it would begin at step {} and ends at step {}",
                    o.late_prune_from, std::min(o.late_prune_until, o.iterations)));
  if (o.coarse_levels > 0 && o.coarse_until >= o.iterations)
    lines.push_back(fmt::format("photos are halved to the end: --coarse-until {} of {} steps",
                                o.coarse_until, o.iterations));
  if (given.contains("sh-target") && o.sh_target != ShTarget::adaptive &&
      asked_degree(o) > o.sh_degree)
    lines.push_back(fmt::format("harmonics end at degree {}, as --sh-degree says", o.sh_degree));
}

}  // namespace

std::vector<std::string> idle_options(const std::set<std::string>& given,
                                      const TrainOptions& options) {
  const O o = resolved(options);
  std::vector<std::string> lines;
  for (const Rule& rule : kRules) {
    if (rule.works(o)) continue;
    std::vector<std::string> idle;
    for (const char* name : rule.names)
      if (given.contains(name)) idle.push_back(fmt::format("--{}", name));
    if (!idle.empty())
      lines.push_back(
          fmt::format("no effect of {}, expected {}", fmt::join(idle, ", "), rule.needed));
  }
  add_stages(given, o, lines);
  return lines;
}

}  // namespace fluxgs::cli
