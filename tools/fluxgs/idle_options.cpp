#include "tools/fluxgs/idle_options.h"

#include <algorithm>
#include <initializer_list>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fluxgs::cli {
namespace {

using O = TrainOptions;

bool has_moments(const O& o) { return reduces_appearance(o) && o.sh_reduce == ShReduction::energy; }
bool integrates(const O& o) {
  return has_moments(o) || (reduces_appearance(o) && o.sh_reduce == ShReduction::uniform_ls);
}
bool by_gradients(const O& o) { return o.densify != Densify::mcmc; }
bool by_views(const O& o) { return o.densify == Densify::multiview; }
bool prunes_by_score(const O& o) {
  return o.late_prune == LatePrune::opacity || (by_gradients(o) && o.prune == Prune::multiview);
}
bool has_scores(const O& o) { return by_views(o) || prunes_by_score(o); }
bool limits_growth(const O& o) {
  return o.densify_growth > 0 || o.max_splats > 0 || o.target_splats > 0 || o.max_memory > 0;
}
bool resets_opacity(const O& o) {
  return by_gradients(o) && o.opacity_reset_interval > 0 &&
         o.opacity_reset_interval < o.densify_until;
}

struct Rule {
  std::initializer_list<const char*> names;
  bool (*works)(const O&);
  const char* needed;
};

const Rule kRules[] = {
    {{"sh-degree-interval", "sh-rest-rate"},
     [](const O& o) { return degree_before_switch(o) > 0; },
     "a --sh-degree and --sh-target of more than 0"},
    {{"sh-reduce"},
     [](const O& o) { return reduces_appearance(o) || o.sh_reduce == ShReduction::none; },
     "a --sh-target below --sh-degree"},
    {{"switch-iter"},
     reduces_appearance,
     "a --sh-target below --sh-degree and another --sh-reduce than none"},
    {{"sh-loss"},
     [](const O& o) { return o.sh_target == ShTarget::adaptive; },
     "--sh-target adaptive"},
    {{"quadrature", "samples"},
     integrates,
     "SH coefficients that are reduced by --sh-reduce energy or uniform-ls"},
    {{"residual", "psi"}, has_moments, "--sh-target 1 --sh-reduce energy"},
    {{"psi-fit-steps", "psi-rate"}, makes_psi, "--sh-target 1 --sh-reduce energy --psi on"},
    {{"phi-rate"}, makes_phi, "--phi on"},
    {{"coarse-until"}, [](const O& o) { return o.coarse_levels > 0; }, "--coarse-levels 1 or more"},
    {{"densify-growth", "prune", "split", "opacity-cap", "opacity-reset-interval"},
     by_gradients,
     "--densify grad or multiview"},
    {{"densify-gradient"},
     [](const O& o) { return by_gradients(o) && o.target_splats == 0; },
     "--densify grad or multiview without --target-splats"},
    {{"densify-size", "split-shrink"},
     [](const O& o) { return by_gradients(o) && o.split == Split::random; },
     "--densify grad or multiview with --split random"},
    {{"growth-rank"},
     [](const O& o) { return by_views(o) && limits_growth(o); },
     "--densify multiview with --densify-growth or another limit"},
    {{"opacity-reset-to"},
     resets_opacity,
     "--densify grad or multiview with an --opacity-reset-interval below --densify-until"},
    {{"prune-world-size", "prune-screen-radius"},
     [](const O& o) { return resets_opacity(o) && o.prune != Prune::none; },
     "--prune multiview or opacity with an --opacity-reset-interval below --densify-until"},
    {{"prune-opacity"},
     [](const O& o) { return !by_gradients(o) || o.prune != Prune::none; },
     "--prune multiview or opacity"},
    {{"mcmc-growth", "mcmc-noise"}, [](const O& o) { return !by_gradients(o); }, "--densify mcmc"},
    {{"quantile-plus", "tau-plus"}, by_views, "--densify multiview"},
    {{"quantile-minus", "tau-minus"}, prunes_by_score, "--prune multiview or --late-prune opacity"},
    {{"cameras", "camera-sampling", "score", "score-loss", "score-unit", "score-share"},
     has_scores,
     "--densify multiview, --prune multiview or --late-prune opacity"},
    {{"azimuth-bins", "elevation-bins"},
     [](const O& o) { return has_scores(o) && o.camera_sampling == CameraSampling::stratified; },
     "--camera-sampling stratified with --densify or --prune multiview, or --late-prune opacity"},
    {{"late-prune-from", "late-prune-interval", "late-prune-until"},
     [](const O& o) { return o.late_prune != LatePrune::off; },
     "--late-prune opacity or contribution"},
    {{"late-prune-opacity"},
     [](const O& o) { return o.late_prune == LatePrune::opacity; },
     "--late-prune opacity"},
    {{"late-prune-share"},
     [](const O& o) { return o.late_prune == LatePrune::contribution; },
     "--late-prune contribution"},
    {{"round-from", "round-interval"},
     [](const O& o) { return o.rounding == Switch::on; },
     "--rounding on"},
};

constexpr const char* kOfFiles[] = {"store-loss", "store-psnr"};

bool any_given(const std::set<std::string>& given, std::initializer_list<const char*> names) {
  return std::ranges::any_of(names, [&](const char* name) { return given.contains(name); });
}

/// Whether something that is due at the multiples of an interval comes to be.
bool happens(int from, int until, int interval) {
  const int first = (std::max(from, 1) + interval - 1) / interval * interval;
  return first <= until;
}

/// Of --sh-target, whatever --sh-degree is.
int asked_degree(O o) {
  o.sh_degree = 3;
  return target_degree(o);
}

void add_stages(const std::set<std::string>& given, const O& o, std::vector<std::string>& lines) {
  const auto never = [&](const char* what, int from, int until, int interval) {
    const int last = std::min(until, o.iterations);
    if (!happens(from, last, interval))
      lines.push_back(fmt::format("{}: that would be every {} steps from {} to {}", what, interval,
                                  from, last));
  };
  // Who has not asked for any may want a short run
  if (any_given(given, {"densify-from", "densify-until", "densify-interval", "target-splats"}))
    never("no splats are added", o.densify_from, o.densify_until, o.densify_interval);
  if (o.late_prune != LatePrune::off &&
      any_given(given,
                {"late-prune", "late-prune-from", "late-prune-until", "late-prune-interval"}))
    never("there is no late pruning", o.late_prune_from, o.late_prune_until, o.late_prune_interval);
  if (o.coarse_levels > 0 && o.coarse_until >= o.iterations &&
      any_given(given, {"coarse-levels", "coarse-until"}))
    lines.push_back(fmt::format("images are halved to the end: --coarse-until {} of {} steps",
                                o.coarse_until, o.iterations));
  if (given.contains("sh-target") && o.sh_target != ShTarget::adaptive &&
      asked_degree(o) > o.sh_degree)
    lines.push_back(
        fmt::format("SH coefficients end at degree {}, as --sh-degree says", o.sh_degree));
  if (reduces_appearance(o) && o.switch_iteration > o.iterations)
    lines.push_back(
        fmt::format("--switch-iter {} is behind the last step, {}: SH coefficients are not reduced",
                    o.switch_iteration, o.iterations));
}

/// What --rounding will not do as asked; `asked`: before it was resolved.
void add_rounding(const O& asked, const O& o, std::vector<std::string>& lines) {
  if (o.rounding == Switch::off) return;
  if (makes_psi(o) || makes_phi(o))
    lines.emplace_back("--rounding on does nothing, as networks make the colours");
  else if (asked.round_from > o.iterations)
    lines.push_back(fmt::format("nothing is rounded: --round-from {} is behind the last step, {}",
                                asked.round_from, o.iterations));
  else if (o.round_from > o.iterations)
    lines.emplace_back(
        "nothing is rounded, as densification or the reduction of SH coefficients lasts to the "
        "end");
  else if (asked.round_from > 0 && o.round_from > asked.round_from)
    lines.push_back(
        fmt::format("rounding begins at step {} instead of {}, after densification and the "
                    "reduction of SH coefficients",
                    o.round_from, asked.round_from));
}

}  // namespace

std::vector<std::string> idle_options(const std::set<std::string>& given,
                                      const TrainOptions& options, bool compact) {
  const O o = resolved(options);
  std::vector<std::string> lines;
  const auto add = [&](const auto& names, const char* needed) {
    std::vector<std::string> idle;
    for (const char* name : names)
      if (given.contains(name)) idle.push_back(fmt::format("--{}", name));
    if (!idle.empty())
      lines.push_back(fmt::format("no effect of {}, expected {}", fmt::join(idle, ", "), needed));
  };
  for (const Rule& rule : kRules)
    if (!rule.works(o)) add(rule.names, rule.needed);
  if (!compact && o.rounding == Switch::off) add(kOfFiles, "a .glb to write, or --rounding on");
  add_stages(given, o, lines);
  add_rounding(options, o, lines);
  return lines;
}

std::set<std::string> options_that_may_be_idle() {
  std::set<std::string> names(std::begin(kOfFiles), std::end(kOfFiles));
  for (const Rule& rule : kRules) names.insert(rule.names.begin(), rule.names.end());
  return names;
}

}  // namespace fluxgs::cli
