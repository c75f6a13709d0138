#include "tools/fluxgs/sweep_plot.h"

#include <algorithm>

#include <fmt/format.h>

namespace fluxgs::cli {
namespace {

PlotSeries& series_of(Plot& plot, const std::string& name, bool line) {
  const auto found = std::ranges::find(plot.series, name, &PlotSeries::name);
  if (found != plot.series.end()) return *found;
  plot.series.push_back({.name = name, .points = {}, .line = line});
  return plot.series.back();
}

}  // namespace

Plot sweep_plot(const SweepTable& table, const SweepGroup& group) {
  const bool by_option = !group.x_label.empty();
  const std::string scenes = table.scenes.size() == 1
                                 ? table.scenes.front().name
                                 : fmt::format("mean over {} scenes", table.scenes.size());
  Plot plot{
      .title = fmt::format("{} ({})", group.title, scenes),
      .x_label = by_option ? group.x_label : "compact .glb (MB)",
      .y_label = by_option ? "PSNR of test photos (dB)" : "PSNR of test photos, compact scene (dB)",
      .log_x = group.log_x,
      .legend_outside = !by_option,
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

}  // namespace fluxgs::cli
