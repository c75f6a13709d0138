#include "trainer/compress/sh_reduction.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fluxgs/io/compact_glb.h"
#include "trainer/compress/adaptive_degree.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/fit_splats.h"
#include "trainer/compress/sphere_prior.h"
#include "trainer/core/psnr.h"
#include "trainer/data/dataset.h"
#include "trainer/model/view_budget.h"

namespace fluxgs {
namespace {

constexpr double kWeightRenders = 2.5;  // for the weights of a view

void reduce_to_one_degree(TrainState& state, const TrainOptions& options, const ViewWeights& views,
                          double prior, const Threads& threads) {
  const int degree = target_sh_degree(options);
  switch (options.get<ShReductionOptions>().reduce) {
    case ShReduction::view_ls:
      state.parameters = fit_to_views(state.parameters, degree, views, prior, threads);
      break;
    case ShReduction::uniform_ls:
      state.parameters = fit_to_sphere(state.parameters, degree, sphere_rule_of(options), threads);
      break;
    default:
      state.parameters = rows_of_degree(state.parameters, degree);
  }
  state.adam.first = rows_of_degree(state.adam.first, degree);
  state.adam.second = rows_of_degree(state.adam.second, degree);
}

/// Bytes of a compact file with default quantization; 0 where the scene cannot be stored.
std::size_t compact_bytes(const SplatCloud& scene) {
  const auto file =
      encode_compact_glb(scene, {.steps = default_quantization_steps(scene)}, kCompactFileName);
  return file ? file->size() : 0;
}

class ShReductionPhase final : public Phase {
 public:
  ShReductionPhase(const ShReductionOptions& options, int first_degree, int degree, int iterations)
      : options_(options),
        first_degree_(first_degree),
        degree_(degree),
        views_(std::min(affordable_views(iterations, kWeightRenders), kMostWeighedViews)) {}

  const char* name() const override { return "SH reduction"; }
  Period period() const override {
    return {.from = options_.iteration, .until = options_.iteration, .interval = 0};
  }
  std::string effect() const override {
    const auto way = kShReductionNames[static_cast<std::size_t>(options_.reduce)];
    return options_.target == ShTarget::adaptive
               ? fmt::format(
                     "leaves each splat the lowest SH degree, by {}; at most {:g} dB "
                     "less on training images",
                     way, options_.max_psnr_drop)
               : fmt::format("reduces all splats to SH degree {} by {}", degree_, way);
  }
  bool reports(int iteration) const override { return period().due(iteration); }
  PhaseWork work(int iteration, std::size_t views) const override {
    if (!reports(iteration)) return {};
    return {.renders = kWeightRenders * static_cast<double>(std::min(views, views_)), .files = 2};
  }
  int sh_degree(int iteration, int degree) const override {
    return iteration > options_.iteration ? std::min(degree, degree_) : degree;
  }

  std::optional<PhaseReport> after_step(Training& t) override {
    if (!period().due(t.state.iteration)) return {};
    const std::size_t bytes_before = compact_bytes(t.cloud());
    const std::vector<Camera> cameras = spread_cameras(cameras_of(t.data.train), views_);
    const ProgressParts parts(t.progress,
                              {kWeightRenders * static_cast<double>(cameras.size()),
                               static_cast<double>(std::min(t.views->size(), kMeasuredViews))});
    const ViewWeights views = view_weights(t.state.parameters, cameras, t.render_options(),
                                           t.threads, {.progress = parts.part(0)});
    // At the resolution of this iteration: larger images have details that nothing has learned yet
    const double mse = mse_of_psnr(t.mean_psnr(*t.views, kMeasuredViews, parts.part(1)));
    const ReductionReport done = reduce_sh(t.state, t.options, views, mse, t.threads);
    PhaseReport report;
    report.bytes = {bytes_before, compact_bytes(t.cloud())};
    report.details = {{"mse_if_truncated", done.dropped},
                      {"mse_if_fitted", done.unexplained},
                      {"sphere_prior", done.sphere_prior},
                      {"splats_of_degree", done.degrees}};
    report.summary = fmt::format("splats of degree 0 to 3: {}", fmt::join(done.degrees, ", "));
    return report;
  }
  Expected<void> load(const std::vector<double>&, const TrainState& state) override {
    const bool reduced = state.iteration >= options_.iteration;
    const bool adaptive = options_.target == ShTarget::adaptive;
    if (sh_degree_of(state.parameters) == (reduced ? degree_ : first_degree_) &&
        state.degrees.empty() == !(reduced && adaptive && state.parameters.size() > 0))
      return {};
    return fail("", "sh_degree", "the SH degrees are not those of the options");
  }

 private:
  ShReductionOptions options_;
  int first_degree_, degree_;
  std::size_t views_;  // that tell from where splats are seen
};

}  // namespace

OptionFields ShReductionOptions::fields(const TrainOptions& all) {
  const bool reduced = reduces_sh(all), adaptive = target == ShTarget::adaptive;
  const bool integrates =
      reduced && (reduce == ShReduction::energy || reduce == ShReduction::uniform_ls);
  const char* below = "a --sh-target below --sh-degree";
  const char* quadratures = "a reduction by --sh-reduce energy or uniform-ls";
  return {choice("sh-target", "SH degree of the finished scene (adaptive: each splat its own)",
                 target, kShTargetNames),
          choice("sh-reduce", "way to reduce SH degrees", reduce, kShReductionNames)
              .only_if(reduced || reduce == ShReduction::none, below),
          whole("sh-reduce-iter",
                "iteration of the reduction (0: a tenth of the iterations, at most 3000; "
                "adaptive: 7/10)",
                iteration, 0, kUnlimited)
              .only_if(reduced, below),
          real("sh-max-psnr-drop",
               "maximum loss of PSNR on training images by adaptive degrees, dB (an estimate)",
               max_psnr_drop, 0, 10)
              .only_if(adaptive, "--sh-target adaptive"),
          choice("quadrature", "rule that integrates over directions", quadrature, kQuadratureNames)
              .only_if(integrates, quadratures),
          whole("samples", "directions of the quadrature", samples, 1, kMaxSphereSamples)
              .only_if(integrates, quadratures)};
}

Expected<void> ShReductionOptions::validate(const TrainOptions& all) const {
  if (reduce == ShReduction::energy && (target != ShTarget::degree_1 || all.sh_degree < 1))
    return fail("", "--sh-reduce",
                fmt::format("energy makes colours of degree 1 only, {}",
                            all.sh_degree >= 1 ? "expected --sh-target 1"
                                               : "expected a --sh-degree of 1 or more"));
  if (target == ShTarget::adaptive && reduce != ShReduction::view_ls)
    return fail("", "--sh-target", "adaptive degrees are fitted, expected --sh-reduce view-ls");
  const bool integrates = reduce == ShReduction::energy || reduce == ShReduction::uniform_ls;
  if (integrates && quadrature == Quadrature::lebedev && samples > kMaxLebedevSamples)
    return fail("", "--samples",
                fmt::format("{} are too many for --quadrature lebedev, expected at most {}",
                            samples, kMaxLebedevSamples));
  return {};
}

int target_sh_degree(const TrainOptions& options) {
  switch (options.get<ShReductionOptions>().target) {
    case ShTarget::degree_0:
      return 0;
    case ShTarget::degree_1:
      return std::min(options.sh_degree, 1);
    case ShTarget::degree_2:
      return std::min(options.sh_degree, 2);
    case ShTarget::degree_3:
    case ShTarget::adaptive:
      break;
  }
  return options.sh_degree;
}

bool reduces_sh(const TrainOptions& options) {
  const auto& own = options.get<ShReductionOptions>();
  return own.target == ShTarget::adaptive ||
         (own.reduce != ShReduction::none && target_sh_degree(options) < options.sh_degree);
}

int first_sh_degree(const TrainOptions& options) {
  return options.get<ShReductionOptions>().reduce == ShReduction::none ? target_sh_degree(options)
                                                                       : options.sh_degree;
}

int sh_reduce_iteration(TrainOptions& options) {
  auto& own = options.get<ShReductionOptions>();
  const int n = options.iterations;
  resolve(own.iteration, own.target == ShTarget::adaptive ? n / 10 * 7 : std::min(n / 10, 3000));
  return own.iteration;
}

SphereRule sphere_rule_of(const TrainOptions& options) {
  const auto& own = options.get<ShReductionOptions>();
  return sphere_rule(own.quadrature, own.samples, options.seed).value();
}

ReductionReport reduce_sh(TrainState& state, const TrainOptions& options, const ViewWeights& views,
                          double train_mse, const Threads& threads) {
  const auto& own = options.get<ShReductionOptions>();
  const bool adaptive = own.target == ShTarget::adaptive;
  const double prior = best_sphere_prior(state.parameters, views, threads);
  const Unexplained unexplained = unexplained_variance(state.parameters, views, prior, threads);
  Unexplained dropped = unexplained;
  dropped.fitted = dropped.truncated;
  ReductionReport report;
  report.sphere_prior = prior;
  std::vector<std::uint8_t> degrees(state.parameters.size(),
                                    static_cast<std::uint8_t>(target_sh_degree(options)));
  if (adaptive)
    degrees = min_degrees(unexplained, threshold_for(unexplained, views.pixels,
                                                     added_mse(train_mse, own.max_psnr_drop)));
  report.dropped = degree_loss(dropped, degrees, views.pixels);
  report.unexplained = degree_loss(unexplained, degrees, views.pixels);
  for (std::uint8_t d : degrees) ++report.degrees[d];

  if (adaptive) {
    state.parameters = fit_to_views(state.parameters, degrees, views, prior, threads);
    state.degrees = std::move(degrees);
  } else {
    reduce_to_one_degree(state, options, views, prior, threads);
  }
  return report;
}

std::unique_ptr<Phase> make_sh_reduction(TrainOptions& options) {
  if (!reduces_sh(options)) return nullptr;
  sh_reduce_iteration(options);
  return std::make_unique<ShReductionPhase>(options.get<ShReductionOptions>(),
                                            first_sh_degree(options), target_sh_degree(options),
                                            options.iterations);
}

}  // namespace fluxgs
