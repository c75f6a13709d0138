#include "trainer/train/trainer.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "fluxgs/io/compact_glb.h"
#include "trainer/compress/quantization_aware.h"
#include "trainer/core/indices.h"
#include "trainer/core/psnr.h"
#include "trainer/densify/camera_sampling.h"
#include "trainer/densify/mcmc.h"
#include "trainer/densify/penalties.h"
#include "trainer/loss/evaluate.h"
#include "trainer/model/initialize.h"
#include "trainer/paper/latent_adam.h"
#include "trainer/raster/blend_weights.h"
#include "trainer/train/memory_budget.h"

namespace fluxgs {
namespace {

/// Of the visible splats; of few it would say nothing.
double pairs_of_a_splat(const RasterCounts& counts) {
  if (counts.visible < 1000) return 0;
  return static_cast<double>(counts.tile_pairs) / static_cast<double>(counts.visible);
}

/// dB between images of a scene with this PSNR and of its file.
double psnr_of_file(double psnr, const TrainOptions& options) {
  const double asked = psnr_of_mse(added_mse(mse_of_psnr(psnr), options.store_loss));
  return options.store_psnr > 0 ? std::min(asked, options.store_psnr) : asked;
}

}  // namespace

double scene_extent(const std::vector<View>& views) {
  glm::dvec3 mean(0);
  for (const View& p : views) mean += p.camera.center() / static_cast<double>(views.size());
  double radius = 0;
  for (const View& p : views) radius = std::max(radius, glm::distance(mean, p.camera.center()));
  // Cameras in one place, but for what the mean is rounded by, have no extent of their own; any
  // positive one keeps the rates above zero.
  constexpr double kRounding = 1e-9;
  return radius > kRounding * (1 + glm::length(mean)) ? 1.1 * radius : 1.0;
}

TrainState initial_state(const Dataset& data, const PointCloud& points, const TrainOptions& options,
                         const Threads& threads) {
  TrainState state;
  const SplatCloud cloud = splats_from_points(points, options.initial_opacity, threads);
  state.parameters = to_parameters(cloud, degree_before_switch(options));
  state.adam.first = PlanarFloats(state.parameters.rows(), cloud.size());
  state.adam.second = PlanarFloats(state.parameters.rows(), cloud.size());
  state.statistics = PlanarFloats(statistic::count, cloud.size());
  state.random.seed(options.seed);
  state.view_order = all_indices(data.train.size());
  state.next_view = static_cast<std::uint32_t>(state.view_order.size());  // shuffled before use
  return state;
}

Trainer::Trainer(const Dataset& data, const TrainOptions& options, TrainState state,
                 const Threads& threads, StageTimes& times)
    : data_(data),
      options_(resolved(options)),
      state_(std::move(state)),
      threads_(threads),
      times_(times),
      extent_(scene_extent(data.train)),
      views_(data.train, options_.coarse_levels),
      rasterizer_(make_cpu_rasterizer(threads, times)),
      loss_(threads),
      networks_(threads) {}

const View& Trainer::next_view() {
  if (state_.next_view >= state_.view_order.size()) {
    shuffle(state_.view_order, state_.random);
    state_.next_view = 0;
  }
  return views_.at(coarse_level(state_.iteration))[state_.view_order[state_.next_view++]];
}

int Trainer::coarse_level(int done) const {
  const int left = options_.coarse_until - done;
  if (left <= 0) return 0;
  // Each size for the same number of iterations
  return static_cast<int>(
      std::ceil(static_cast<double>(options_.coarse_levels) * left / options_.coarse_until));
}

RenderOptions Trainer::render_options() const {
  RenderOptions render = options_.render;
  render.sh_degree = sh_degree_in_use();
  render.depth_spread_max = options_.depth_spread;
  return render;
}

int Trainer::sh_degree_in_use() const {
  if (state_.switched_at > 0) return sh_degree_of(state_.parameters);
  return std::min(degree_before_switch(options_), state_.iteration / options_.sh_degree_interval);
}

LearningRates Trainer::rates() const {
  const double t = std::min(1.0, static_cast<double>(state_.iteration) / options_.position_decay);
  const double position = std::exp((1 - t) * std::log(std::max(options_.position_rate, 1e-30)) +
                                   t * std::log(options_.position_rate_final));
  return {position * extent_,    options_.log_scale_rate, options_.rotation_rate,
          options_.opacity_rate, options_.sh_dc_rate,     options_.sh_rest_rate};
}

bool Trainer::due(int from, int until, int interval) const {
  const int i = state_.iteration;
  return i >= from && i <= until && interval > 0 && i % interval == 0;
}

SplatScores Trainer::scores(const std::vector<std::uint32_t>& views) {
  if (state_.networks)  // the parameters hold the colours of splats that were just seen only
    bake(state_.networks->model, state_.parameters, state_.networks->latents, threads_,
         state_.parameters);
  return score_splats(data_.train, views, state_.parameters, render_options(), options_,
                      *rasterizer_, threads_);
}

/// Of all training views; the other scores are left out.
SplatScores Trainer::contributions() const {
  SplatScores scores;
  scores.contribution.resize(state_.parameters.size());
  scores.pixels.resize(state_.parameters.size());
  const auto add = [](std::vector<float>& sums, const std::vector<float>& more) {
    std::ranges::transform(sums, more, sums.begin(), std::plus<>());
  };
  BlendWeights weights(state_.parameters, render_options(), threads_);
  for (const View& view : data_.train) {
    add(scores.contribution, weights.of(view.camera));
    add(scores.pixels, weights.pixels());
  }
  return scores;
}

/// The options with the limit that memory sets to the number of splats.
TrainOptions Trainer::options_for_growth() const {
  TrainOptions o = options_;
  if (o.max_memory == 0) return o;
  const std::uint64_t fit = splats_in_memory(data_, o, std::max(state_.max_pairs, kDefaultPairs));
  o.max_splats = o.max_splats > 0 ? std::min(o.max_splats, fit) : std::max<std::uint64_t>(fit, 1);
  return o;
}

DensifyCounts Trainer::densify() {
  const TrainOptions options = options_for_growth();
  if (options.densify == Densify::mcmc) return relocate_and_grow(state_, options);
  if (options.densify == Densify::grad && options.prune != Prune::multiview)
    return densify_and_prune(state_, options, extent_, nullptr);
  const SplatScores s = scores(sample_cameras(data_.train, options, state_.random));
  return densify_and_prune(state_, options, extent_, &s);
}

LatePruneReport Trainer::late_prune() {
  StageTimer timer(times_, Stage::late_prune);
  LatePruneReport report{.splats_before = state_.parameters.size(),
                         .train_psnr_before = mean_psnr(data_.train)};
  prune_late(state_, options_,
             options_.late_prune == LatePrune::contribution
                 ? contributions()
                 : scores(sample_cameras(data_.train, options_, state_.random)));
  report.splats_after = state_.parameters.size();
  report.train_psnr_after = mean_psnr(data_.train);
  return report;
}

void Trainer::control_density(StepReport& report) {
  const TrainOptions& o = options_;
  if (due(o.densify_from, o.densify_until, o.densify_interval)) report.densified = densify();
  // Before opacities are reset, after which they tell nothing
  if (o.late_prune != LatePrune::off &&
      due(o.late_prune_from, o.late_prune_until, o.late_prune_interval))
    report.pruned_late = late_prune();
  // None with the last densification: nothing would remove what stays faint
  if (o.densify != Densify::mcmc && due(1, o.densify_until - 1, o.opacity_reset_interval))
    reset_opacity(state_, options_);
}

/// Lets the networks make the colours of the splats that a camera can see, from their true
/// opacities.
void Trainer::shade(const Camera& camera, const RenderOptions& render) {
  if (!state_.networks) return;
  StageTimer timer(times_, Stage::networks);
  std::vector<std::uint32_t> seen;
  const std::vector<std::uint8_t>& visible =
      rasterizer_->find_visible(state_.parameters, camera, render);
  for (std::uint32_t i = 0; i < state_.parameters.size(); ++i)
    if (visible[i]) seen.push_back(i);
  dropout_.exchange(state_.parameters);
  networks_.shade(state_.networks->model, state_.parameters, state_.networks->latents, seen,
                  state_.parameters);
  dropout_.exchange(state_.parameters);
}

void Trainer::optimize() {
  StageTimer timer(times_, Stage::optimizer);
  const AdamConstants constants{options_.beta1, options_.beta2, options_.epsilon};
  const std::vector<std::uint8_t>& visible = rasterizer_->visible();
  if (has_penalties(options_))
    add_penalties(state_.parameters, visible, options_, rasterizer_->gradient(), threads_);
  const AdamStep adam(constants, state_.iteration, adam_kernels(best_isa()));
  const auto rows = [&](int first, int end, const std::vector<std::uint8_t>& of) {
    adam_step(state_.parameters, state_.adam, rasterizer_->gradient(), of, rates(), adam,
              {first, end}, threads_);
  };
  const int end = row::count(sh_degree_in_use());
  if (state_.networks) {
    rows(0, row::sh_dc, visible);
    optimize_networks(constants);
  } else if (state_.degrees.empty()) {
    rows(0, end, visible);
  } else {
    rows(0, row::sh_rest, visible);
    for (int degree = 1; row::count(degree) <= end; ++degree)
      rows(row::count(degree - 1), row::count(degree), visible_of_degree(degree));
  }
}

/// Steps that the latents' moments know of: E comes to be at the switch, c′ was trained before.
int Trainer::latent_steps() const {
  return state_.networks->model.psi ? state_.iteration - state_.switched_at : state_.iteration;
}

void Trainer::optimize_networks(const AdamConstants& constants) {
  StageTimer timer(times_, Stage::networks);
  NetworkState& n = *state_.networks;
  if (latent_gradient_.size() != n.latents.size())
    latent_gradient_ = PlanarFloats(n.latents.rows(), n.latents.size());
  networks_.backpropagate(n.model, rasterizer_->gradient(), rasterizer_->visible(),
                          latent_gradient_);
  networks_.step(n.model, {.psi = options_.psi_rate, .phi = options_.phi_rate}, constants);
  latent_adam_step(n.latents, n.adam, latent_gradient_, rasterizer_->visible(),
                   {.constant = options_.sh_dc_rate, .directional = options_.sh_rest_rate},
                   AdamStep(constants, latent_steps(), adam_kernels(best_isa())), threads_);
}

/// Visible splats that have SH coefficients of a degree.
std::vector<std::uint8_t> Trainer::visible_of_degree(int degree) const {
  std::vector<std::uint8_t> out = rasterizer_->visible();
  for (std::size_t i = 0; i < state_.degrees.size(); ++i)
    if (state_.degrees[i] < degree) out[i] = 0;
  return out;
}

double Trainer::mean_psnr(const std::vector<View>& views) const {
  if (views.empty()) return 0;
  const ViewRenderer render = cpu_view_renderer(cloud(), options_.render, threads_);
  PlanarImage target;
  double sum = 0;
  for (const View& view : views) {
    to_planar(view.rgb, threads_, target);
    sum += std::min(psnr(*render(view.camera), target), kAsGoodAsTheView);
  }
  return sum / static_cast<double>(views.size());
}

double Trainer::stored_psnr() const { return psnr_of_file(mean_psnr(data_.train), options_); }

/// Finds the steps and rounds for the first time.
RoundingReport Trainer::begin_rounding() {
  RoundingReport report;
  report.train_psnr_before = mean_psnr(data_.train);
  const SplatCloud exact = cloud();
  const CompactGoal goal{cameras_of(data_.train), options_.render,
                         psnr_of_file(report.train_psnr_before, options_)};
  auto found =
      compact_within(exact, exact, goal, {.steps = default_compact_steps(exact)}, threads_, {});
  if (!found) return {.error = found.error()};
  state_.rounding = RoundingState{found->options.steps, std::move(found->options.costs), {}};
  const auto file = round_parameters(state_);
  if (!file) {
    state_.rounding.reset();
    return {.error = file.error()};
  }
  report.bytes = file->size();
  report.train_psnr_after = mean_psnr(data_.train);
  return report;
}

/// What the networks make is not rounded, and a lost file is no reason to lose the scene.
std::optional<RoundingReport> Trainer::round() {
  StageTimer timer(times_, Stage::rounding);
  const TrainOptions& o = options_;
  if (o.rounding == Switch::off || state_.networks || state_.parameters.size() == 0) return {};
  if (state_.iteration == o.round_from) return begin_rounding();
  if (!state_.rounding) return {};
  if ((state_.iteration - o.round_from) % o.round_interval != 0 && !done()) return {};
  const auto file = round_parameters(state_);
  if (file) return {};
  state_.rounding.reset();
  return RoundingReport{.error = file.error()};
}

SwitchReport Trainer::switch_appearance() {
  StageTimer timer(times_, Stage::appearance);
  SwitchReport report;
  report.train_psnr_before = mean_psnr(data_.train);
  const double test_psnr_before = mean_psnr(data_.test);
  report.bytes_before = compact_bytes();
  const ViewWeights views =
      view_weights(state_.parameters, cameras_of(data_.train), render_options(), threads_);
  // Of the images of the last step: full-size ones have details that nothing may know of yet
  const double trained_psnr = mean_psnr(views_.at(coarse_level(state_.iteration - 1)));
  report.reduction =
      reduce_appearance(state_, options_, views, mse_of_psnr(trained_psnr), threads_);
  state_.switched_at = state_.iteration;
  report.train_psnr_after = mean_psnr(data_.train);
  if (!data_.test.empty()) report.test_psnr = {test_psnr_before, mean_psnr(data_.test)};
  report.bytes_after = compact_bytes();
  return report;
}

/// With the usual steps; 0 where the scene cannot be stored.
std::size_t Trainer::compact_bytes() const {
  const SplatCloud scene = cloud();
  const auto file =
      encode_compact_glb(scene, {.steps = default_compact_steps(scene)}, "compact .glb");
  return file ? file->size() : 0;
}

StepReport Trainer::step() {
  const View& view = next_view();
  const RenderOptions render = render_options();
  ++state_.iteration;

  StepReport report;
  dropout_.hide(state_.parameters, dropout_share(options_, data_.train.size(), state_.iteration),
                state_.random);
  shade(view.camera, render);
  rasterizer_->forward(state_.parameters, view.camera, render);
  report.raster = rasterizer_->counts();
  state_.max_pairs = std::max(state_.max_pairs, pairs_of_a_splat(report.raster));
  {
    StageTimer timer(times_, Stage::loss);
    to_planar(view.rgb, threads_, target_);
    report.sums = loss_.run(rasterizer_->color(), target_, options_.lambda_dssim);
    report.loss = report.sums.loss(options_.lambda_dssim);
  }
  rasterizer_->backward(state_.parameters, loss_.gradient());
  dropout_.restore(state_.parameters, rasterizer_->gradient().row(row::opacity));
  optimize();

  StageTimer timer(times_, Stage::densify);
  if (options_.densify == Densify::mcmc)
    add_noise(state_, options_, rates().position, threads_);
  else if (state_.iteration <= options_.densify_until)
    gather_statistics(state_, *rasterizer_);
  // Before splats are added, which shakes the image for a moment
  if (state_.iteration == options_.switch_iteration && reduces_appearance(options_))
    report.switched = switch_appearance();
  control_density(report);
  report.rounded = round();
  return report;
}

SplatCloud Trainer::cloud() const {
  if (!state_.networks) return to_cloud(state_.parameters, sh_degree_of(state_.parameters));
  PlanarFloats colors = state_.parameters;
  bake(state_.networks->model, state_.parameters, state_.networks->latents, threads_, colors);
  return to_cloud(colors, 1);
}

}  // namespace fluxgs
