// fluxgs report codec: what a scene takes in each format, against what its images lose.
#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/spz.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/plot.h"
#include "tools/fluxgs/commands/report.h"
#include "tools/fluxgs/commands/report_scene.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/view_sensitivity.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct CodecReport {
  std::string scene, plot, report, lpips;
  std::vector<std::string> compare;
  DataOptions data;
  int sh_degree = 3;
};

/// The step scales of the curve, relative to the default one.
constexpr double kCurve[] = {0.25, 0.35, 0.5, 0.71, 1, 1.41, 2, 2.83, 4};

/// Files of plain floats would make the chart of all others flat.
constexpr double kMaxReportedPsnr = 100;

/// One file of the scene.
struct FormatRow {
  std::string name;
  bool compact = false;  ///< on the curve of the compact codec
  std::size_t splats = 0, bytes = 0;
  SceneQuality quality;  ///< beside the uncompressed scene
  double encode_ms = 0, decode_ms = 0;
  AttributeBits attribute_bits;

  double bits_per_splat() const {
    return 8.0 * static_cast<double>(bytes) / static_cast<double>(std::max<std::size_t>(splats, 1));
  }
};

/// Scene and renderer of every row.
class Bench {
 public:
  explicit Bench(QualityBench quality) : quality_(std::move(quality)) {}

  const SceneError& error() const { return quality_.error(); }

  /// Reads the file, with its time, and looks at it.
  Expected<FormatRow> measure(std::string name, const std::vector<std::byte>& file,
                              int sh_degree) const {
    FormatRow row;
    row.bytes = file.size();
    const double start = milliseconds();
    auto scene = read_scene(file, name);
    if (!scene) return std::unexpected(scene.error());
    row.decode_ms = milliseconds() - start;
    row.name = std::move(name);
    row.attribute_bits = scene->attribute_bits;
    limit_sh_degree(scene->cloud, sh_degree);
    return look(std::move(row), scene->cloud);
  }

  Expected<FormatRow> look(FormatRow row, const SplatCloud& cloud) const {
    row.splats = cloud.size();
    const auto quality = quality_.measure(cloud);
    if (!quality) return std::unexpected(quality.error());
    row.quality = *quality;
    return row;
  }

  static double milliseconds() {
    using namespace std::chrono;
    return std::chrono::duration<double, std::milli>(steady_clock::now().time_since_epoch())
        .count();
  }

 private:
  QualityBench quality_;
};

using Encoder = std::function<Expected<std::vector<std::byte>>()>;

Expected<FormatRow> encode_and_measure(const Bench& bench, const std::string& name, int sh_degree,
                                       const Encoder& encode) {
  const double start = Bench::milliseconds();
  const auto file = encode();
  const double taken = Bench::milliseconds() - start;
  if (!file) return std::unexpected(file.error());
  auto row = bench.measure(name, *file, sh_degree);
  if (row) row->encode_ms = taken;
  return row;
}

/// All formats that can be written, at their default settings.
std::vector<std::pair<std::string, Encoder>> default_encoders(const SplatCloud& cloud) {
  std::vector<std::pair<std::string, Encoder>> list;
  for (const SceneFormat& format : scene_formats())
    if (format.encode != nullptr && format.max_sh_degree >= cloud.sh_degree)
      list.emplace_back(std::string(format.name),
                        [&cloud, &format] { return format.encode(cloud, "scene", {}); });
  list.emplace_back("spz 4",
                    [&cloud] { return encode_spz(cloud, "scene", SpzOptions{.version = 4}); });
  return list;
}

/// The curve of the compact codec, balanced once at its default steps.
Expected<std::vector<FormatRow>> compact_rows(const CodecReport& s, const Bench& bench,
                                              const SplatCloud& cloud,
                                              const CompactOptions& options, Progress& progress,
                                              int& done) {
  const CompactSearch search(cloud, bench.error(), options);
  auto steps = search.balanced(options.steps);
  if (steps) steps = search.balanced(*steps);
  if (!steps) return std::unexpected(steps.error());
  std::vector<FormatRow> rows;
  for (const double step_scale : kCurve) {
    CompactOptions own = options;
    own.steps = scaled(*steps, step_scale);
    own.steps.position = std::max(own.steps.position, finest_position_step(cloud));
    auto row = encode_and_measure(bench, fmt::format("compact {:g}", step_scale), s.sh_degree,
                                  [&] { return encode_compact_glb(cloud, own, "scene"); });
    if (!row) return std::unexpected(row.error());
    row->compact = true;
    rows.push_back(std::move(*row));
    progress.update(++done, rows.back().name);
  }
  return rows;
}

Expected<std::vector<FormatRow>> compare_rows(const CodecReport& s, const Bench& bench) {
  std::vector<FormatRow> rows;
  for (const std::string& path : s.compare) {
    const double start = Bench::milliseconds();
    auto scene = load_scene(path);
    if (!scene) return std::unexpected(scene.error());
    FormatRow row;
    row.decode_ms = Bench::milliseconds() - start;
    row.name =
        fmt::format("{} ({})", std::filesystem::path(path).filename().string(), scene->format);
    row.bytes = scene->bytes;
    row.attribute_bits = scene->attribute_bits;
    limit_sh_degree(scene->cloud, s.sh_degree);
    auto measured = bench.look(std::move(row), scene->cloud);
    if (!measured) return std::unexpected(measured.error());
    rows.push_back(std::move(*measured));
  }
  return rows;
}

Expected<std::vector<FormatRow>> all_rows(const CodecReport& s, const Bench& bench,
                                          const SplatCloud& cloud, const CompactOptions& options) {
  const auto encoders = default_encoders(cloud);
  Progress progress("files", static_cast<int>(encoders.size() + std::size(kCurve)), 0);
  int done = 0;
  std::vector<FormatRow> rows;
  for (const auto& [name, encode] : encoders) {
    progress.update(++done, name);
    auto row = encode_and_measure(bench, name, s.sh_degree, encode);
    if (row)
      rows.push_back(std::move(*row));
    else  // not every format can hold every scene
      spdlog::warn("warning: {}: left out: {}", name, row.error().what);
  }
  auto compact = compact_rows(s, bench, cloud, options, progress, done);
  if (!compact) return compact;
  progress.clear();
  std::ranges::move(*compact, std::back_inserter(rows));
  auto compared = compare_rows(s, bench);
  if (!compared) return compared;
  std::ranges::move(*compared, std::back_inserter(rows));
  return rows;
}

json to_json(const CodecReport& s, const SplatCloud& cloud, const std::vector<FormatRow>& rows) {
  json list = json::array();
  for (const FormatRow& row : rows) {
    list.push_back({{"name", row.name},
                    {"splats", row.splats},
                    {"bytes", row.bytes},
                    {"bits_per_splat", row.bits_per_splat()},
                    {"encode_ms", row.encode_ms},
                    {"decode_ms", row.decode_ms},
                    {"attributes", row.attribute_bits}});
    add_quality(row.quality, list.back());
  }
  return {{"scene", s.scene},
          {"splats", cloud.size()},
          {"sh_degree", cloud.sh_degree},
          {"data", s.data.folder},
          {"lpips", s.lpips.empty() ? json(nullptr) : json(s.lpips)},
          {"rows", std::move(list)}};
}

void print_table(const std::vector<FormatRow>& rows) {
  fmt::print("{:<34}{:>10}{:>8}{:>10}{:>10}{:>9}{:>9}{:>9}\n", "file", "bytes", "bits", "PSNR",
             "images", "LPIPS", "encode", "decode");
  for (const FormatRow& row : rows) {
    const SceneQuality& q = row.quality;
    fmt::print("{:<34}{:>10}{:>8.1f}{:>10}{:>10}{:>9}{:>7.0f}ms{:>7.0f}ms\n", row.name, row.bytes,
               row.bits_per_splat(), decibels(q.psnr), q.view_psnr ? decibels(*q.view_psnr) : "",
               q.lpips_cell(), row.encode_ms, row.decode_ms);
  }
  fmt::print("\nbits a splat of each attribute\n");
  for (const FormatRow& row : rows) {
    fmt::print("{:<34}", row.name);
    for (const auto& [attribute, bits] : row.attribute_bits)
      fmt::print(" {} {:.1f}", attribute, bits);
    fmt::print("\n");
  }
}

Plot plot_of(const CodecReport& s, const std::vector<FormatRow>& rows) {
  Plot plot{.title = fmt::format("{}: size against error",
                                 std::filesystem::path(s.scene).filename().string()),
            .x_label = "bits a splat",
            .y_label = "PSNR to the images of the uncompressed scene (dB)",
            .log_x = true,
            .series = {{"compact .glb", {}}}};
  for (const FormatRow& row : rows) {
    const std::pair point(row.bits_per_splat(), row.quality.psnr);
    if (row.compact)
      plot.series[0].points.push_back(point);
    else if (row.quality.psnr < kMaxReportedPsnr)
      plot.series.push_back({row.name, {point}, false});
  }
  return plot;
}

Expected<void> report(const CodecReport& s) {
  if (auto ok = check_report_outputs(s.plot, s.report); !ok) return ok;
  auto loaded = load_report_scene(s.scene, s.sh_degree, s.data);
  if (!loaded) return std::unexpected(loaded.error());
  const SplatCloud& cloud = loaded->scene.cloud;
  const Dataset* views = loaded->views();
  const Threads threads(s.data.threads);
  auto lpips = load_report_lpips(s.lpips, *loaded, s.data, threads);
  if (!lpips) return std::unexpected(lpips.error());
  RenderOptions render;
  render.background = s.data.background_color();
  const Bench bench(QualityBench(cloud, views, std::move(*lpips), render, threads));
  CompactOptions options{.steps = default_quantization_steps(cloud)};
  if (views != nullptr)
    options.sensitivity = view_sensitivity(cameras_of(views->train), cloud, false, render, threads,
                                           {.progress = show_work("views")});
  const auto rows = all_rows(s, bench, cloud, options);
  if (!rows) return std::unexpected(rows.error());
  auto given = give_report(s.report, to_json(s, cloud, *rows), [&] { print_table(*rows); });
  if (!given || s.plot.empty()) return given;
  return write_plot(s.plot, plot_of(s, *rows));
}

}  // namespace

void add_report_codec(CLI::App& app, Action& action) {
  auto s = std::make_shared<CodecReport>();
  CLI::App* command = app.add_subcommand("codec", "Size and error of a scene in each format");
  command->footer(
      "PSNR is measured on views of the data set, or of an orbit, against the images of SCENE\n"
      "itself; with --data also against the test images. \"compact N\": quantization steps "
      "balanced\n"
      "for this scene, as --min-psnr of convert does, times N.\n"
      "Example: fluxgs report codec garden.ply --data captures/garden --plot codec.png");
  command->add_option("scene", s->scene, "the scene file")->required();
  command->add_option("--data", s->data.folder, "the data set with the images");
  add_report_lpips(*command, s->lpips);
  command->add_option("--compare", s->compare, "other files of the same scene");
  command->add_option("--sh-degree", s->sh_degree, "highest SH degree to keep")
      ->check(whole_in(0, 3))
      ->capture_default_str();
  command->add_option("--plot", s->plot, "write a plot of size against error: .png or .svg");
  command->add_option("--json", s->report, "write the results as JSON (-: standard output)");
  add_data_options(*command, s->data);
  command->callback([s, &action] { action = [s] { return report(*s); }; });
}

}  // namespace fluxgs::cli
