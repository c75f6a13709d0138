#include "tools/fluxgs/commands/plot.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include <fmt/format.h>

#include "fluxgs/io/file.h"
#include "fluxgs/sanitize.h"
#include "tools/fluxgs/terminal/files.h"
#include "trainer/core/process.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

/// gnuplot's single quotes: nothing in them is special but the quote, which is doubled.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20) continue;
    result += c;
    if (c == '\'') result += c;
  }
  return result + "'";
}

/// gnuplot has eight colours; a shape of its own for each round of them.
int point_type(std::size_t series) {
  constexpr int kFilled[] = {7, 5, 9, 11, 13};  // circle, square, triangles, diamond
  return kFilled[series / 8 % std::size(kFilled)];
}

bool is_drawn(const std::pair<double, double>& point) {
  return std::isfinite(point.first) && std::isfinite(point.second);
}

/// The points that can be drawn, as gnuplot reads them.
std::string data_of(const PlotSeries& series) {
  std::string data;
  for (const auto& point : series.points)
    if (is_drawn(point)) data += fmt::format("{} {}\n", point.first, point.second);
  return data;
}

bool has_points(const Plot& plot) {
  return std::ranges::any_of(plot.series, [](const PlotSeries& series) {
    return std::ranges::any_of(series.points, is_drawn);
  });
}

std::string script_of(const Plot& plot, const fs::path& out) {
  const bool svg = out.extension() == ".svg";
  std::string script = fmt::format(
      "set terminal {} size 960,600 noenhanced {}\nset output {}\nset title {}\nset xlabel {}\n"
      "set ylabel {}\nset grid\nset key outside right top\nset encoding utf8\n",
      svg ? "svg" : "pngcairo", svg ? "background 'white'" : "", quoted(out.string()),
      quoted(plot.title), quoted(plot.x_label), quoted(plot.y_label));
  if (plot.log_x) script += "set logscale x 2\n";
  std::string commands;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& series = plot.series[i];
    script += fmt::format("$s{} << EOD\n{}EOD\n", i, data_of(series));
    commands += fmt::format("{}$s{} with {} linewidth 2 pointtype {} title {}", i > 0 ? ", " : "",
                            i, series.line ? "linespoints" : "points pointsize 1.5", point_type(i),
                            quoted(series.name));
  }
  return script + "plot " + commands + "\n";
}

/// The last line that gnuplot said.
std::string reason_in(const fs::path& log) {
  std::ifstream in(log);
  std::string reason = "no reason given";
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) reason = one_line(line, 200);
  return reason;
}

/// Runs gnuplot on a plot; the bytes of its image.
Expected<std::vector<std::byte>> draw(const Plot& plot, const std::string& path) {
  const TempFolder work;
  const auto gnuplot = find_program("gnuplot");
  if (work.path().empty() || !gnuplot)
    return fail(path, "--plot", "no temporary folder can be made");
  const fs::path script = work.path() / "script", log = work.path() / "log";
  const fs::path drawn = work.path() / ("plot" + fs::path(path).extension().string());
  const std::string text = script_of(plot, drawn);
  if (auto ok = write_file_atomic(script, std::as_bytes(std::span(text))); !ok)
    return std::unexpected(ok.error());
  const int status = run({*gnuplot, {script.string()}, log});
  auto bytes = read_file(drawn);
  if (status != 0 || !bytes || bytes->empty())
    return fail(path, "--plot", "gnuplot could not draw it: " + reason_in(log));
  return bytes;
}

}  // namespace

Expected<void> check_plot(const std::string& path) {
  const std::string extension = fs::path(path).extension().string();
  if (extension != ".png" && extension != ".svg")
    return fail(path, "--plot", "expected a name that ends in .png or .svg");
  if (!find_program("gnuplot"))
    return fail(path, "--plot",
                "gnuplot is not installed, which draws charts (tools/setup has it)");
  return {};
}

Expected<void> write_plot(const std::string& path, const Plot& plot) {
  if (auto ok = check_plot(path); !ok) return ok;
  if (!has_points(plot))
    return fail(path, "--plot", "there is nothing to draw: no finite number, all is exact");
  const auto bytes = draw(plot, path);
  if (!bytes) return std::unexpected(bytes.error());
  return write_file_atomic(path, *bytes);
}

}  // namespace fluxgs::cli
