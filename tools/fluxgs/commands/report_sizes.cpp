// fluxgs report sizes: what a scene of fewer splats takes, against what its images lose.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/plot.h"
#include "tools/fluxgs/commands/report.h"
#include "tools/fluxgs/commands/report_scene.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/compress/scene_reduction.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct SizesReport {
  std::string scene, plot, report, lpips;
  DataOptions data;
  int counts = 9, sh_degree = 3;
};

constexpr double kFewerSplats = 0.7;               // of each number to the one before
constexpr double kStepScales[] = {0.7, 1.4, 2.8};  // to the default steps

/// One compact file.
struct SizeRow {
  std::size_t splats = 0, bytes = 0;
  double step_scale = 1;
  SceneQuality quality;
  bool on_front = false;  ///< no file is smaller and as near to the whole scene
};

/// Stores a cloud and looks at what the file shows.
Expected<SizeRow> measure_file(const QualityBench& bench, const SplatCloud& cloud,
                               double step_scale) {
  const CompactOptions options{.steps = default_quantization_steps(cloud, step_scale)};
  const auto file = encode_compact_glb(cloud, options, "scene");
  if (!file) return std::unexpected(file.error());
  const auto stored = read_scene(*file, "scene");
  if (!stored) return std::unexpected(stored.error());
  const auto quality = bench.measure(stored->cloud);
  if (!quality) return std::unexpected(quality.error());
  SizeRow row;
  row.splats = cloud.size();
  row.bytes = file->size();
  row.step_scale = step_scale;
  row.quality = *quality;
  return row;
}

void mark_smallest(std::vector<SizeRow>& rows) {
  for (SizeRow& a : rows)
    a.on_front = std::ranges::none_of(rows, [&](const SizeRow& b) {
      return (b.bytes < a.bytes && b.quality.psnr >= a.quality.psnr) ||
             (b.bytes <= a.bytes && b.quality.psnr > a.quality.psnr);
    });
}

Expected<std::vector<SizeRow>> size_rows(const SizesReport& s, const QualityBench& bench,
                                         SceneReduction& reduction) {
  constexpr double kReductionShare = 3;  // of the time of a number of splats, to one of each file
  const auto whole = static_cast<double>(reduction.size());
  std::vector<double> shares;
  for (int i = 0; i < s.counts; ++i) {
    const double left = std::pow(kFewerSplats, i);
    shares.push_back(i > 0 ? kReductionShare * left : 0);
    shares.push_back(static_cast<double>(std::size(kStepScales)) * left);
  }
  const ProgressParts parts(show_work("sizes"), shares);
  std::vector<SizeRow> rows;
  for (std::size_t i = 0; i < static_cast<std::size_t>(s.counts); ++i) {
    const double count = whole * std::pow(kFewerSplats, static_cast<double>(i));
    reduction.reduce(static_cast<std::size_t>(std::max(1.0, std::round(count))),
                     {.progress = parts.part(2 * i)});
    const SplatCloud cloud = reduction.cloud();
    const ProgressReport progress = parts.part(2 * i + 1);
    for (std::size_t k = 0; k < std::size(kStepScales); ++k) {
      const auto row = measure_file(bench, cloud, kStepScales[k]);
      if (!row) return std::unexpected(row.error());
      rows.push_back(*row);
      if (progress) progress(k + 1, std::size(kStepScales));
    }
  }
  mark_smallest(rows);
  return rows;
}

json sizes_json(const SizesReport& s, const SplatCloud& whole, const std::vector<SizeRow>& rows) {
  json list = json::array();
  for (const SizeRow& row : rows) {
    list.push_back({{"splats", row.splats},
                    {"bytes", row.bytes},
                    {"step_scale", row.step_scale},
                    {"on_front", row.on_front}});
    add_quality(row.quality, list.back());
  }
  return {{"scene", s.scene},
          {"splats", whole.size()},
          {"sh_degree", whole.sh_degree},
          {"data", s.data.folder},
          {"lpips", s.lpips.empty() ? json(nullptr) : json(s.lpips)},
          {"rows", std::move(list)}};
}

void print_sizes(std::vector<SizeRow> rows) {
  std::ranges::sort(rows, std::greater(), &SizeRow::bytes);
  fmt::print("{:>10}{:>10}{:>8}{:>8}{:>10}{:>10}{:>9}\n", "bytes", "splats", "steps", "bits",
             "PSNR", "images", "LPIPS");
  for (const SizeRow& row : rows)
    fmt::print(
        "{:>10}{:>10}{:>8g}{:>8.1f}{:>10}{:>10}{:>9}{}\n", row.bytes, row.splats, row.step_scale,
        8.0 * static_cast<double>(row.bytes) / static_cast<double>(row.splats),
        decibels(row.quality.psnr), row.quality.view_psnr ? decibels(*row.quality.view_psnr) : "",
        row.quality.lpips_cell(), row.on_front ? "  Pareto" : "");
}

Plot sizes_plot(const SizesReport& s, const std::vector<SizeRow>& rows) {
  Plot plot{.title = fmt::format("{}: size against error",
                                 std::filesystem::path(s.scene).filename().string()),
            .x_label = "bytes of a compact .glb",
            .y_label = "PSNR (dB)",
            .log_x = true,
            .series = {{"to the whole scene", {}}}};
  PlotSeries photos{"to the test images", {}}, others{"other files", {}, false};
  for (const SizeRow& row : rows) {
    const auto bytes = static_cast<double>(row.bytes);
    (row.on_front ? plot.series[0] : others).points.emplace_back(bytes, row.quality.psnr);
    if (row.on_front && row.quality.view_psnr)
      photos.points.emplace_back(bytes, *row.quality.view_psnr);
  }
  for (PlotSeries* series : {&plot.series[0], &photos}) std::ranges::sort(series->points);
  if (!photos.points.empty()) plot.series.push_back(std::move(photos));
  plot.series.push_back(std::move(others));
  return plot;
}

Expected<void> report_scene_sizes(const SizesReport& s) {
  if (auto ok = check_report_outputs(s.plot, s.report); !ok) return ok;
  auto loaded = load_report_scene(s.scene, s.sh_degree, s.data);
  if (!loaded) return std::unexpected(loaded.error());
  const SplatCloud& cloud = loaded->scene.cloud;
  const Dataset* views = loaded->views();
  const Threads threads(s.data.threads);
  ReductionOptions options;
  options.render.background = s.data.background_color();
  auto lpips = load_report_lpips(s.lpips, *loaded, s.data, threads);
  if (!lpips) return std::unexpected(lpips.error());
  const QualityBench bench(cloud, views, std::move(*lpips), options.render, threads);
  SceneReduction reduction(cloud, reduction_cameras(cloud, loaded->scene.start, views), options,
                           threads);
  const auto rows = size_rows(s, bench, reduction);
  if (!rows) return std::unexpected(rows.error());
  auto given = give_report(s.report, sizes_json(s, cloud, *rows), [&] { print_sizes(*rows); });
  if (!given || s.plot.empty()) return given;
  return write_plot(s.plot, sizes_plot(s, *rows));
}

}  // namespace

void add_report_sizes(CLI::App& app, Action& action) {
  auto s = std::make_shared<SizesReport>();
  CLI::App* command =
      app.add_subcommand("sizes", "Size and error of a scene with ever fewer splats");
  command->footer(
      "Splats are taken away as --max-splats of convert does, 30% each time, and each number is\n"
      "stored with three scales of the quantization steps. PSNR is measured on views of the data\n"
      "set, or of an orbit, against the images of SCENE itself; with --data also against the test\n"
      "images. \"Pareto\": no other file is as small and as near to SCENE.\n"
      "Example: fluxgs report sizes garden.ply --data captures/garden --plot sizes.svg --json "
      "sizes.json");
  command->add_option("scene", s->scene, "the scene file")->required();
  command->add_option("--data", s->data.folder, "the data set with the images");
  add_report_lpips(*command, s->lpips);
  command->add_option("--counts", s->counts, "numbers of splats, the whole scene among them")
      ->check(whole_in(1, 30))
      ->capture_default_str();
  command->add_option("--sh-degree", s->sh_degree, "highest SH degree to keep")
      ->check(whole_in(0, 3))
      ->capture_default_str();
  command->add_option("--plot", s->plot, "write a plot of size against error: .png or .svg");
  command->add_option("--json", s->report, "write the results as JSON (-: standard output)");
  add_data_options(*command, s->data);
  command->callback([s, &action] { action = [s] { return report_scene_sizes(*s); }; });
}

}  // namespace fluxgs::cli
