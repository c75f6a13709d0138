#include "trainer/train/trainer.h"

#include <algorithm>
#include <cmath>

#include "trainer/compress/compression.h"
#include "trainer/core/indices.h"
#include "trainer/core/psnr.h"
#include "trainer/data/photo_memory.h"
#include "trainer/raster/view_renderer.h"
#include "trainer/train/initialize.h"
#include "trainer/train/memory_budget.h"

namespace fluxgs {
namespace {

/// TrainState::splat_worth of an event that removed splats.
double worth(const Change<double>& psnr, const Change<std::size_t>& splats) {
  const auto left = static_cast<double>(std::max<std::size_t>(splats.after, 1));
  return (psnr.before - psnr.after) / std::log(static_cast<double>(splats.before) / left);
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

double cooldown_factor(const CommonOptions& options, int iteration) {
  const double length = options.cooldown * options.iterations;
  const double passed = iteration - (options.iterations - length);
  if (passed <= 0) return 1;
  return std::pow(options.cooldown_to, std::min(passed / length, 1.0));
}

TrainState initial_state(const Dataset& data, const PointCloud& points, const TrainOptions& options,
                         const Threads& threads) {
  TrainState state;
  const SplatCloud cloud = splats_from_points(points, options.initial_opacity, threads);
  state.parameters = to_parameters(cloud, initial_sh_degree(options));
  state.adam.first = PlanarFloats(state.parameters.rows(), cloud.size());
  state.adam.second = PlanarFloats(state.parameters.rows(), cloud.size());
  state.statistics = PlanarFloats(statistic::count, cloud.size());
  state.random.seed(options.seed);
  state.view_order = all_indices(data.train.size());
  state.next_view = static_cast<std::uint32_t>(state.view_order.size());  // shuffled before use
  return state;
}

Trainer::Trainer(const Dataset& dataset, const TrainOptions& asked, TrainState initial,
                 const Threads& pool, Profiler& times)
    : Trainer(dataset,
              std::make_unique<Owned>(make_schedule(asked, dataset.train, pool), std::move(initial),
                                      make_cpu_rasterizer(pool, times)),
              pool, times) {}

Trainer::Trainer(const Dataset& dataset, std::unique_ptr<Owned> owned, const Threads& pool,
                 Profiler& times)
    : Training(dataset, owned->schedule.options, pool, owned->state, *owned->rasterizer, times,
               scene_extent(dataset.train)),
      owned_(std::move(owned)),
      schedule_(owned_->schedule),
      loss_(pool) {
  // What a checkpoint holds was checked when it was read
  for (const auto& phase : schedule_.phases)
    (void)phase->load(state.phase_values[phase->name()], state);
  state.phase_values.clear();
}

TrainState Trainer::saved_state() const {
  TrainState saved = state;
  for (const auto& phase : schedule_.phases)
    if (std::vector<double> values = phase->save(); !values.empty())
      saved.phase_values[phase->name()] = std::move(values);
  return saved;
}

const View& Trainer::next_view() {
  if (state.next_view >= state.view_order.size()) {
    shuffle(state.view_order, state.random);
    state.next_view = 0;
  }
  return (*views)[state.view_order[state.next_view++]];
}

RenderOptions Trainer::render_options() const {
  RenderOptions result = options.render;
  result.sh_degree = sh_degree_of(state.parameters);
  result.depth_spread_max = options.depth_spread;
  for (const auto& phase : schedule_.phases) phase->configure(result, state);
  return result;
}

double Trainer::position_lr() const {
  const double t =
      std::min(1.0, static_cast<double>(state.iteration) / options.position_lr_iterations);
  return extent * std::exp((1 - t) * std::log(std::max(options.position_lr, 1e-30)) +
                           t * std::log(options.position_lr_final));
}

std::uint64_t Trainer::max_splats() const {
  if (options.max_memory == 0) return options.max_splats;
  const std::uint64_t fit =
      splats_in_memory(data, options, std::max(state.max_pairs, kDefaultPairs));
  return options.max_splats > 0 ? std::min(options.max_splats, fit)
                                : std::max<std::uint64_t>(fit, 1);
}

void Trainer::complete_colors() {
  for (const auto& phase : schedule_.phases) phase->bake_colors(state, state.parameters);
}

void Trainer::optimize() {
  ProfileScope scope(profiler, "adam");
  const AdamConstants constants{options.beta1, options.beta2, options.epsilon};
  const double f = cooldown_factor(options, state.iteration);
  const LearningRates rates{f * position_lr(),      f * options.scale_lr, f * options.rotation_lr,
                            f * options.opacity_lr, f * options.sh_dc_lr, f * options.sh_rest_lr};
  const AdamStep adam(constants, state.iteration, adam_kernels(best_isa()));
  const auto rows = [&](int first, int end, const std::vector<std::uint8_t>& of) {
    adam_step(state.parameters, state.adam, rasterizer.gradient(), of, rates, adam, {first, end},
              threads);
  };
  const std::vector<std::uint8_t>& visible = rasterizer.visible();
  const int end = optimized_rows.value_or(row::count(render_options().sh_degree));
  if (state.degrees.empty()) return rows(0, end, visible);
  rows(0, std::min<int>(row::sh_rest, end), visible);
  for (int degree = 1; row::count(degree) <= end; ++degree)
    rows(row::count(degree - 1), row::count(degree), visible_of_degree(degree));
}

/// Visible splats that have SH of a degree.
std::vector<std::uint8_t> Trainer::visible_of_degree(int degree) const {
  std::vector<std::uint8_t> out = rasterizer.visible();
  for (std::size_t i = 0; i < state.degrees.size(); ++i)
    if (state.degrees[i] < degree) out[i] = 0;
  return out;
}

double Trainer::mean_psnr(const std::vector<View>& of, std::size_t most,
                          const ProgressReport& shown) const {
  if (of.empty()) return 0;
  const ViewRenderer renderer = cpu_view_renderer(cloud(), options.render, threads);
  const std::vector<std::uint32_t> measured = spread_indices(of.size(), most);
  ProgressCounter counter(shown, measured.size());
  PlanarImage target;
  double sum = 0;
  for (const std::uint32_t i : measured) {
    const View& one = of[i];
    to_planar(one.rgb, threads, target);
    sum += std::min(psnr(*renderer(one.camera), target, one.used), kMaxPsnr);
    let_go(one);
    counter.add_one();
  }
  return sum / static_cast<double>(measured.size());
}

double Trainer::compressed_psnr() const {
  return fluxgs::compressed_psnr(mean_psnr(data.train), options.get<CompressionOptions>());
}

std::uint64_t Trainer::rejected_gradients() const {
  std::uint64_t sum = rasterizer.rejected_gradients();
  for (const auto& phase : schedule_.phases) sum += phase->rejected_gradients();
  return sum;
}

void Trainer::run_after_step(Phase& phase, IterationReport& report) {
  ProfileScope scope(profiler, phase.name());
  if (phase.reports(state.iteration)) return run_event(phase, report);
  std::optional<PhaseReport> event = phase.after_step(*this);
  if (event) add_event(phase, std::move(*event), state.parameters.size(), report);
}

/// Measures before and after. One progress is of all of it.
void Trainer::run_event(Phase& phase, IterationReport& report) {
  const ProgressReport outer = progress;
  const auto renders = [](const std::vector<View>& of) {
    return static_cast<double>(std::min(of.size(), kEventViews));
  };
  const double train = renders(data.train), test = renders(data.test);
  const ProgressParts parts(
      outer, {train, test, phase.work(state.iteration, data.train.size()).share(), train, test});
  const auto measured = [&](const std::vector<View>& of, std::size_t part) {
    return mean_psnr(of, kEventViews, parts.part(part));
  };
  const double train_psnr = measured(data.train, 0);
  const double test_psnr = measured(data.test, 1);
  const std::size_t splats = state.parameters.size();
  progress = parts.part(2);
  std::optional<PhaseReport> event = phase.after_step(*this);
  progress = outer;
  if (event) {
    event->train_psnr = {train_psnr, measured(data.train, 3)};
    if (state.parameters.size() < splats)
      state.splat_worth = worth(event->train_psnr, {splats, state.parameters.size()});
    const double test_after = measured(data.test, 4);
    if (!data.test.empty()) event->test_psnr = {test_psnr, test_after};
    add_event(phase, std::move(*event), splats, report);
  }
}

void Trainer::add_event(const Phase& phase, PhaseReport event, std::size_t splats_before,
                        IterationReport& report) const {
  event.name = phase.name();
  event.iteration = state.iteration;
  event.splats = {splats_before, state.parameters.size()};
  report.phases.push_back(std::move(event));
}

const Phase* Trainer::event_at(int iteration) const {
  for (const auto& phase : schedule_.phases)
    if (phase->reports(iteration)) return phase.get();
  return nullptr;
}

IterationReport Trainer::step() {
  const auto for_phases = [&](void (Phase::*point)(Training&)) {
    for (const auto& phase : schedule_.phases) {
      ProfileScope scope(profiler, phase->name());
      (phase.get()->*point)(*this);
    }
  };
  views = &data.train;
  optimized_rows.reset();
  for_phases(&Phase::begin);
  view = &next_view();
  render = render_options();
  ++state.iteration;

  IterationReport report;
  for_phases(&Phase::before_render);
  rasterizer.forward(state.parameters, view->camera, render);
  report.raster = rasterizer.counts();
  state.max_pairs = std::max(state.max_pairs, pairs_per_splat(report.raster));
  {
    ProfileScope scope(profiler, "loss");
    to_planar(view->rgb, threads, target_);
    shift_background(view->alpha, glm::vec3(render.background) - view->background, target_);
    report.sums = loss_.run(rasterizer.color(), target_, options.lambda_dssim, view->used);
    report.loss = report.sums.loss(options.lambda_dssim);
  }
  transmittance_gradient = nullptr;
  for_phases(&Phase::before_backward);
  rasterizer.backward(state.parameters, loss_.gradient(), transmittance_gradient);
  for_phases(&Phase::after_backward);
  optimize();
  let_go(*view);
  for (const auto& phase : schedule_.phases) run_after_step(*phase, report);
  return report;
}

SplatCloud Trainer::cloud() const {
  PlanarFloats colors;
  for (const auto& phase : schedule_.phases) {
    if (!phase->has_colors()) continue;
    colors = state.parameters;
    phase->bake_colors(state, colors);
  }
  const PlanarFloats& shown = colors.size() > 0 ? colors : state.parameters;
  SplatCloud cloud = to_cloud(shown, sh_degree_of(shown));
  cloud.filter = options.render.filter.value_or(ScreenFilter{});
  return cloud;
}

}  // namespace fluxgs
