// Line charts, drawn by gnuplot.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::cli {

struct PlotSeries {
  std::string name;
  std::vector<std::pair<double, double>> points;
  bool line = true;  ///< false: points only
};

struct Plot {
  std::string title, x_label, y_label;
  bool log_x = false;
  std::vector<PlotSeries> series;
};

/// Checks that a chart of this name can be drawn: .png or .svg, and gnuplot is installed.
Expected<void> check_plot(const std::string& path);

/// Draws a chart under its final name. Points that are not finite are left out.
Expected<void> write_plot(const std::string& path, const Plot& plot);

}  // namespace fluxgs::cli
