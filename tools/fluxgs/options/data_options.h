// A data set on the command line: its options, and loading it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "tools/fluxgs/cameras/cameras.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

struct DataOptions {
  std::string folder;
  int downscale = 0;  ///< 0: only images that are very large (LoadOptions)
  int threads = 0;
  std::string holdout = {};  ///< "none", "every-N", a file of names, or empty: as the data set says
  double photo_memory = 0;   ///< MiB (LoadOptions::max_photo_bytes)
  int trained_side = 0;      ///< LoadOptions::trained_side
  int video_frames = 0;      ///< 0: as before, or the default
  std::vector<double> background{0, 0, 0};
  MaskUse masks = MaskUse::automatic;

  glm::dvec3 background_color() const { return {background[0], background[1], background[2]}; }
};

/// For options: a number from `min` to `max` and, unlike with CLI::Range, never NaN.
CLI::Validator in_range(double min, double max);

/// The same for whole numbers.
CLI::Validator whole_in(std::int64_t min, std::int64_t max);

/// The same for CLI::Option::transform(), of numbers as people write them: 50000, 5e4, 50k; with
/// the unit "B" also 500kB.
CLI::Validator amount_in(std::int64_t min, std::int64_t max, const std::string& unit = "");

/// --background r,g,b, each from 0 to 1. `background` must live as long as `command`.
void add_background_option(CLI::App& command, std::vector<double>& background);

/// --downscale, --holdout, --video-frames, --background ("r,g,b", each from 0 to 1) and --threads.
void add_data_options(CLI::App& command, DataOptions& options);

/// --masks, for commands that compare with photos.
void add_masks_option(CLI::App& command, MaskUse& masks);

/// --split, "test" or "train".
void add_split_option(CLI::App& command, std::string& split);

/// --size WIDTHxHEIGHT. `size` must live as long as `command`.
void add_size_option(CLI::App& command, ImageSize& size, const std::string& help);

/// Loads the data set and prints its warnings.
Expected<Dataset> load(const DataOptions& options);

/// Nothing if no folder was named.
Expected<std::optional<Dataset>> load_if_given(const DataOptions& options);

}  // namespace fluxgs::cli
