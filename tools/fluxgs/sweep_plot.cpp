#include "tools/fluxgs/sweep_plot.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace fluxgs::cli {
namespace {

PlotSeries& series_of(Plot& plot, const std::string& name, bool line) {
  const auto found = std::ranges::find(plot.series, name, &PlotSeries::name);
  if (found != plot.series.end()) return *found;
  plot.series.push_back({.name = name, .points = {}, .line = line});
  return plot.series.back();
}

std::string scenes_of(const SweepTable& table) {
  return table.scenes.size() == 1 ? table.scenes.front().name
                                  : fmt::format("mean over {} scenes", table.scenes.size());
}

/// By iteration and the place among the points of the same iteration: the switch has two.
using CurvePoints = std::map<std::pair<int, int>, std::vector<double>>;

CurvePoints curve_points(const std::vector<const RunOutcome*>& runs) {
  CurvePoints points;
  for (const RunOutcome* run : runs) {
    std::map<int, int> seen;
    for (const auto& [iteration, psnr] : run->curve)
      points[{iteration, seen[iteration]++}].push_back(psnr);
  }
  return points;
}

/// The runs of the seeds that have finished on every scene, as scenes differ more than rows do.
std::vector<const RunOutcome*> finished_runs(const SweepTable& table, std::size_t row) {
  std::vector<const RunOutcome*> runs;
  for (std::size_t seed = 0; seed < table.seeds.size(); ++seed) {
    std::vector<const RunOutcome*> of_seed;
    for (std::size_t scene = 0; scene < table.scenes.size(); ++scene)
      if (const RunOutcome& o = table.at(scene, row, seed); o.state == RunState::finished)
        of_seed.push_back(&o);
    if (of_seed.size() == table.scenes.size())
      runs.insert(runs.end(), of_seed.begin(), of_seed.end());
  }
  return runs;
}

PlotSeries mean_curve(const std::string& name, const std::vector<const RunOutcome*>& runs) {
  PlotSeries series{.name = name, .points = {}};
  for (const auto& [at, values] : curve_points(runs))
    if (values.size() == runs.size())
      series.points.emplace_back(at.first, statistic_of(values).mean);
  return series;
}

double best_of(const Plot& plot) {
  double best = 0;
  for (const PlotSeries& series : plot.series)
    for (const auto& [iteration, psnr] : series.points) best = std::max(best, psnr);
  return best;
}

}  // namespace

Plot sweep_plot(const SweepTable& table, const SweepGroup& group) {
  const bool by_option = !group.x_label.empty();
  Plot plot{
      .title = fmt::format("{} ({})", group.title, scenes_of(table)),
      .x_label = by_option ? group.x_label : "compact .glb (MB)",
      .y_label = by_option ? "PSNR of test images (dB)" : "PSNR of test images, compact scene (dB)",
      .log_x = group.log_x,
      .series = {}};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const SweepRow& row = table.rows[i];
    if (row.group != group.name) continue;
    const Statistic psnr = over_scenes(table, i, by_option ? "psnr" : "stored_psnr");
    const double x =
        by_option ? row.x.value_or(0) : 1e-6 * over_scenes(table, i, "stored_bytes").mean;
    if (psnr.count == 0) continue;
    PlotSeries& series = series_of(plot, by_option ? row.series : row.label, by_option);
    series.points.emplace_back(x, psnr.mean);
    series.y_errors.push_back(psnr.deviation);
  }
  return plot;
}

Plot sweep_curves(const SweepTable& table, const SweepGroup& group) {
  constexpr double kShownDecibels = 6;
  Plot plot{.title = fmt::format("{} ({})", group.title, scenes_of(table)),
            .x_label = "iteration",
            .y_label = "PSNR of test images (dB)",
            .series = {}};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].group != group.name) continue;
    PlotSeries series = mean_curve(table.rows[i].label, finished_runs(table, i));
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  plot.y_from = best_of(plot) - kShownDecibels;
  return plot;
}

}  // namespace fluxgs::cli
