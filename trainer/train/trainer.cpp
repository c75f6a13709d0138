#include "trainer/train/trainer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "trainer/densify/camera_sampling.h"
#include "trainer/densify/mcmc.h"
#include "trainer/model/initialize.h"

namespace fluxgs {
namespace {

std::vector<std::uint32_t> all_views(std::size_t count) {
  std::vector<std::uint32_t> views(count);
  std::iota(views.begin(), views.end(), 0u);
  return views;
}

}  // namespace

double scene_extent(const std::vector<Photo>& photos) {
  glm::dvec3 mean(0);
  for (const Photo& p : photos) mean += p.camera.center() / static_cast<double>(photos.size());
  double radius = 0;
  for (const Photo& p : photos) radius = std::max(radius, glm::distance(mean, p.camera.center()));
  // A single camera has no extent of its own; any positive one keeps the rates above zero.
  return radius > 0 ? 1.1 * radius : 1.0;
}

TrainState initial_state(const Dataset& data, const PointCloud& points, const TrainOptions& options,
                         const Threads& threads) {
  TrainState state;
  const SplatCloud cloud = splats_from_points(points, options.initial_opacity, threads);
  state.parameters = to_parameters(cloud, options.sh_degree);
  state.adam.first = PlanarFloats(state.parameters.rows(), cloud.size());
  state.adam.second = PlanarFloats(state.parameters.rows(), cloud.size());
  state.statistics = PlanarFloats(statistic::count, cloud.size());
  state.random.seed(options.seed);
  state.view_order.resize(data.train.size());
  std::iota(state.view_order.begin(), state.view_order.end(), 0u);
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
      photos_(data.train, options_.coarse_levels),
      rasterizer_(make_cpu_rasterizer(threads, times)),
      loss_(threads) {}

const Photo& Trainer::next_photo() {
  if (state_.next_view >= state_.view_order.size()) {
    shuffle(state_.view_order, state_.random);
    state_.next_view = 0;
  }
  return photos_.at(coarse_level())[state_.view_order[state_.next_view++]];
}

int Trainer::coarse_level() const {
  const int left = options_.coarse_until - state_.iteration;
  if (left <= 0) return 0;
  // Each size for the same number of iterations
  return static_cast<int>(
      std::ceil(static_cast<double>(options_.coarse_levels) * left / options_.coarse_until));
}

RenderOptions Trainer::render_options() const {
  RenderOptions render = options_.render;
  render.sh_degree = sh_degree_in_use();
  return render;
}

int Trainer::sh_degree_in_use() const {
  return std::min(options_.sh_degree, state_.iteration / options_.sh_degree_interval);
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
  return score_splats(data_.train, views, state_.parameters, render_options(), options_,
                      *rasterizer_, threads_);
}

DensifyCounts Trainer::densify() {
  if (options_.densify == Densify::mcmc) return relocate_and_grow(state_, options_);
  if (options_.densify == Densify::grad && options_.prune != Prune::multiview)
    return densify_and_prune(state_, options_, extent_, nullptr);
  const SplatScores s = scores(sample_cameras(data_.train, options_, state_.random));
  return densify_and_prune(state_, options_, extent_, &s);
}

DensifyCounts Trainer::late_prune() {
  const SplatScores s = scores(options_.late_prune == LatePrune::contribution
                                   ? all_views(data_.train.size())
                                   : sample_cameras(data_.train, options_, state_.random));
  return prune_late(state_, options_, s);
}

DensifyCounts Trainer::control_density() {
  DensifyCounts counts;
  const TrainOptions& o = options_;
  if (due(o.densify_from, o.densify_until, o.densify_interval)) counts = densify();
  if (o.densify != Densify::mcmc && due(1, o.densify_until, o.opacity_reset_interval))
    reset_opacity(state_, options_);
  if (o.late_prune != LatePrune::off &&
      due(o.late_prune_from, o.late_prune_until, o.late_prune_interval))
    counts = late_prune();
  return counts;
}

StepReport Trainer::step() {
  const Photo& photo = next_photo();
  const RenderOptions render = render_options();
  ++state_.iteration;

  StepReport report;
  rasterizer_->forward(state_.parameters, photo.camera, render);
  report.raster = rasterizer_->counts();
  {
    StageTimer timer(times_, Stage::loss);
    to_planar(photo.rgb, threads_, target_);
    report.sums = loss_.run(rasterizer_->color(), target_, options_.lambda_dssim);
    report.loss = report.sums.loss(options_.lambda_dssim);
  }
  rasterizer_->backward(state_.parameters, loss_.gradient());
  {
    StageTimer timer(times_, Stage::optimizer);
    if (options_.densify == Densify::mcmc)
      add_penalties(state_.parameters, rasterizer_->visible(), options_, rasterizer_->gradient(),
                    threads_);
    adam_step(state_.parameters, state_.adam, rasterizer_->gradient(), rasterizer_->visible(),
              rates(), {options_.beta1, options_.beta2, options_.epsilon}, state_.iteration,
              render.sh_degree, threads_, adam_kernels(best_isa()));
  }
  StageTimer timer(times_, Stage::densify);
  if (options_.densify == Densify::mcmc)
    add_noise(state_, options_, rates().position, threads_);
  else if (state_.iteration <= options_.densify_until)
    gather_statistics(state_, *rasterizer_);
  report.densified = control_density();
  return report;
}

SplatCloud Trainer::cloud() const { return to_cloud(state_.parameters, options_.sh_degree); }

}  // namespace fluxgs
