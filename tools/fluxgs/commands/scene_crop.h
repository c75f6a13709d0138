// Leaving out a part of a scene from the command line.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace CLI {
class App;
}

namespace fluxgs::cli {

/// Limits to what is kept; empty or zero: none. Axes are those that `fluxgs info` shows.
struct CropOptions {
  std::vector<double> box;     ///< least x, y, z, then greatest, scene units; of splats' centres
  std::vector<double> sphere;  ///< centre and radius, scene units
  double min_opacity = 0;      ///< 0…1
  bool crops() const { return !box.empty() || !sphere.empty() || min_opacity > 0; }
};

/// --crop, --crop-sphere, --min-opacity.
void add_crop_options(CLI::App& command, CropOptions& options);

/// Throws CLI::ValidationError where nothing can lie within a limit.
void check_crop(const CropOptions& options);

/// The options that limit, "--crop and --min-opacity".
std::string limits_of(const CropOptions& options);

/// Leaves out the splats beyond the limits; the order of the others stays. Returns how many.
std::size_t crop_scene(const CropOptions& options, SplatCloud& cloud);

}  // namespace fluxgs::cli
