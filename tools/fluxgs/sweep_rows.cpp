#include "tools/fluxgs/sweep_rows.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/fluxgs/method_options.h"
#include "trainer/train/schedule.h"

namespace fluxgs::cli {
namespace {

using Options = std::vector<std::string>;

constexpr const char *kOurs = "flux", *kPaper = "flux-paper";

/// Adds a row for each value of one option. `common`: options that all have.
void add_values(std::vector<SweepRow>& rows, const std::string& group, const std::string& option,
                const std::vector<double>& values, const Options& common = {}) {
  for (const double value : values) {
    const std::string text = fmt::format("{:g}", value);
    Options options = common;
    options.insert(options.end(), {option, text});
    rows.push_back(
        {group, fmt::format("{}-{}", group, text), text, kOurs, std::move(options), group, value});
  }
}

/// Adds a row for each name of a choice, called PREFIX-NAME.
void add_choices(std::vector<SweepRow>& rows, const std::string& group, const std::string& prefix,
                 const std::string& option, const std::vector<std::string>& names,
                 const Options& common = {}) {
  for (const std::string& name : names) {
    const std::string label = fmt::format("{} {}", option.substr(2), name);
    Options options = common;
    options.insert(options.end(), {option, name});
    rows.push_back({group, fmt::format("{}-{}", prefix, name), label, kOurs, std::move(options)});
  }
}

void add_presets(std::vector<SweepRow>& rows) {
  for (const std::string& name : preset_names()) rows.push_back({"presets", name, name, name, {}});
}

struct NamedOptions {
  const char *name, *label;
  Options options;
};

void add_named(std::vector<SweepRow>& rows, const char* group, const char* preset,
               const std::vector<NamedOptions>& list) {
  for (const NamedOptions& n : list) rows.push_back({group, n.name, n.label, preset, n.options});
}

/// The paper's table "Ablation": each part of the method taken away from the whole.
void add_parts(std::vector<SweepRow>& rows) {
  add_named(
      rows, "parts", kPaper,
      {{"full", "full", {}},
       {"no-mc-sea", "without MC-SEA (truncated)", {"--sh-reduce", "truncate"}},
       {"no-delta-c", "without Δc", {"--phi", "off"}},
       {"no-multiview-densify", "without multi-view densification", {"--densify", "gradient"}},
       {"no-multiview-prune", "without multi-view pruning", {"--prune", "opacity"}},
       {"no-prune", "without pruning", {"--prune", "none"}}});
}

/// What `flux` adds to 3DGS and to the paper, each taken away from the whole.
void add_ours(std::vector<SweepRow>& rows) {
  add_named(rows, "ours", kOurs,
            {{"ours-full", "full", {}},
             {"ours-no-dropout", "without dropout", {"--dropout", "0"}},
             {"ours-no-coarse-start", "without halved images first", {"--resolution-levels", "0"}},
             {"ours-no-error-rank", "growth by gradients only", {"--densify", "gradient"}},
             {"ours-random-split", "splits at random", {"--split", "random"}},
             {"ours-unlimited-growth", "without a limit to growth", {"--densify-growth", "0"}},
             {"ours-no-late-prune", "without late pruning", {"--late-prune", "off"}},
             {"ours-no-adaptive-degree", "all of degree 3", {"--sh-target", "3"}},
             {"ours-no-quantize-aware", "quantized only when stored", {"--quantize-aware", "off"}},
             {"ours-no-depth-spread", "splats of any depth", {"--depth-spread", "0"}}});
}

/// The integrals behind E_mag and E_dir, which only the paper's reduction needs. Lebedev's rules
/// are of certain sizes.
void add_quadratures(std::vector<SweepRow>& rows) {
  const auto add = [&](const std::string& rule, const std::vector<int>& sizes) {
    for (const int samples : sizes)
      rows.push_back({"quadrature",
                      fmt::format("{}-{}", rule, samples),
                      fmt::format("{} {}", rule, samples),
                      kOurs,
                      {"--sh-target", "1", "--sh-reduce", "energy", "--quadrature", rule,
                       "--samples", fmt::format("{}", samples)},
                      rule,
                      samples});
  };
  add("mc", {64, 256, 1024, 2048, 4096});
  add("fibonacci", {64, 256, 1024, 2048, 4096});
  add("lebedev", {86, 110, 194, 302});
}

/// How what is between views and scores is chosen, each different from the whole.
void add_scores(std::vector<SweepRow>& rows) {
  add_named(rows, "score", kOurs,
            {{"score-full", "full", {}},
             {"score-random-views", "views at random", {"--camera-sampling", "random"}},
             {"score-alpha", "α instead of αT", {"--score-weight", "alpha"}},
             {"score-l1", "L1 instead of L1 and D-SSIM", {"--score-loss", "l1"}},
             {"score-raw", "errors as they are", {"--score-unit", "raw"}},
             {"score-by-gradient", "the largest gradients first", {"--growth-rank", "gradient"}}});
}

bool sets(const Options& options, std::string_view name) {
  return std::ranges::any_of(options, [&](const std::string& word) {
    return word.starts_with("--") && word.substr(0, word.find('=')) == name;
  });
}

}  // namespace

const std::vector<SweepGroup>& sweep_groups() {
  static const std::vector<SweepGroup> groups = {
      {"presets", "Presets"},
      {"ours", "The parts of flux, each taken away"},
      {"parts", "The parts of the paper's method, each taken away"},
      {"quadrature", "Quadrature of the energy moments", "directions", true},
      {"score", "How splats are scored over views"},
      {"cameras", "Views behind a score", "views"},
      {"quantile-plus", "Quantile of densification", "Q⁺"},
      {"quantile-minus", "Quantile of pruning", "Q⁻"},
      {"size", "Size of the scene, by the gradient above which splats are added"},
      {"store", "Precision of the file, by how near its images are to the scene's (dB)"},
      {"sh", "SH degree, and how it is reached"},
      {"switch", "The step at which SH coefficients are reduced", "step"},
      {"densify", "Densification"}};
  return groups;
}

std::vector<SweepRow> all_sweep_rows() {
  std::vector<SweepRow> rows;
  add_presets(rows);
  add_ours(rows);
  add_parts(rows);
  add_quadratures(rows);
  add_scores(rows);
  add_values(rows, "cameras", "--score-views", {2, 4, 6, 8, 10, 12});
  add_values(rows, "quantile-plus", "--quantile-plus", {0.4, 0.5, 0.6, 0.7, 0.8, 0.9});
  // Of the prunings that look at it. The one in between takes splats too low-opacity to be in any
  // image, which therefore have no score: only the late one makes a difference
  add_values(rows, "quantile-minus", "--quantile-minus", {0.01, 0.1, 0.3, 0.5, 0.7, 0.9},
             {"--prune", "multiview", "--late-prune", "opacity"});
  add_values(rows, "size", "--densify-gradient", {1e-4, 2e-4, 3e-4, 4.5e-4, 6e-4, 9e-4});
  // Of which the other limit must not take the decision
  add_values(rows, "store", "--compress-psnr", {36, 38, 40, 42, 44, 46},
             {"--max-psnr-drop", "0.01"});
  add_choices(rows, "sh", "sh-target", "--sh-target", {"0", "1", "2", "3", "adaptive"});
  add_choices(rows, "sh", "sh-reduce", "--sh-reduce",
              {"view-ls", "truncate", "uniform-ls", "energy"}, {"--sh-target", "1"});
  add_choices(rows, "sh", "phi", "--phi", {"on"}, {"--sh-target", "1"});
  const Options energy = {"--sh-target", "1", "--sh-reduce", "energy"};
  add_choices(rows, "sh", "residual", "--residual", {"3-1", "3-2", "3-0"}, energy);
  add_choices(rows, "sh", "psi", "--psi", {"off"}, energy);
  add_values(rows, "switch", "--sh-reduce-iter", {1000, 2000, 3000, 4000, 5000, 6000});
  add_choices(rows, "densify", "densify", "--densify", {"multiview", "gradient"});
  // As its authors use it
  add_choices(rows, "densify", "densify", "--densify", {"mcmc"},
              {"--densify-interval", "100", "--opacity-reset-interval", "0", "--opacity-weight",
               "0.01", "--scale-weight", "0.01"});
  return rows;
}

Expected<std::vector<SweepRow>> chosen_sweep_rows(const Options& only, const std::string& preset) {
  if (const auto names = preset_names(); !preset.empty() && !std::ranges::count(names, preset))
    return fail("", "--preset",
                fmt::format("'{}' is not a preset; expected {}", preset, fmt::join(names, ", ")));
  std::vector<SweepRow> rows = all_sweep_rows();
  for (const std::string& word : only) {
    const auto named = [&](const SweepRow& r) { return r.name == word || r.group == word; };
    if (std::ranges::any_of(rows, named)) continue;
    Options names;
    for (const SweepGroup& group : sweep_groups()) names.push_back(group.name);
    return fail("", "--only",
                fmt::format("'{}' is neither a group ({}) nor a row (see --list)", word,
                            fmt::join(names, ", ")));
  }
  std::erase_if(rows, [&](const SweepRow& r) {
    return !only.empty() && !std::ranges::count(only, r.group) && !std::ranges::count(only, r.name);
  });
  for (SweepRow& row : rows)
    if (!preset.empty() && row.group != "presets") row.preset = preset;
  return rows;
}

Options merged_options(const Options& common, const Options& changes) {
  Options merged;
  bool taken = true;
  for (const std::string& word : common) {
    if (word.starts_with("--")) taken = !sets(changes, word.substr(0, word.find('=')));
    if (taken) merged.push_back(word);
  }
  merged.insert(merged.end(), changes.begin(), changes.end());
  return merged;
}

Options picked_options(const Options& options, std::initializer_list<std::string_view> names) {
  Options kept;
  bool keep = false;
  for (const std::string& word : options) {
    if (word.starts_with("--"))
      keep = std::ranges::count(names, std::string_view(word).substr(0, word.find('='))) > 0;
    if (!keep) continue;
    const std::size_t value = word.starts_with("--") ? word.find('=') : std::string::npos;
    kept.push_back(word.substr(0, value));
    if (value != std::string::npos) kept.push_back(word.substr(value + 1));
  }
  return kept;
}

Expected<TrainOptions> meaning_of(const std::string& name, const Options& options) {
  auto meaning = preset(name);
  if (!meaning) return meaning;
  CLI::App app;
  app.allow_extras();
  MethodOptions given;
  add_method_options(app, given);
  try {
    app.parse(Options(options.rbegin(), options.rend()));
  } catch (const CLI::ParseError& error) {
    return fail("", "", error.what());
  }
  cli::apply(given, *meaning);  // not the one of std
  return plan_schedule(*meaning).options;
}

}  // namespace fluxgs::cli
