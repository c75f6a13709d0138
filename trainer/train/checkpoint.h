// Training, interrupted and continued: a file that holds everything a run needs to go on as if it
// had never stopped.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "fluxgs/error.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/data/dataset.h"
#include "trainer/model/options.h"
#include "trainer/model/train_state.h"

namespace fluxgs {

struct Checkpoint {
  TrainOptions options;
  std::string preset;
  int downscale = 1;  ///< LoadOptions::downscale of the images
  std::size_t train_views = 0;
  std::uint64_t views_hash = 0;  ///< hash_views() of them; checked when the run goes on
  TrainState state;
  std::string history = {};  ///< the caller's, of what was before; nothing here looks at it
  std::optional<InitialView> start = {};  ///< of the scene
};

/// Every option by its name on the command line, for checkpoints and reports.
nlohmann::json options_json(const TrainOptions& options);

/// A hash of images: their cameras and pixels.
std::uint64_t hash_views(const std::vector<View>& views);

/// File layout (little-endian): "FLUXGSCK", u32 version, u32 size of a JSON header, the header
/// (options, counts, random state, history), then the rows of parameters, both moments, statistics
/// and attached values as float32, the values of phases as float64, and degrees (a byte each); then
/// a 64-bit FNV-1a hash of everything before it. Written whole or not at all.
Expected<void> write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// Errors: not a checkpoint, another version, damaged content, values that no training with its
/// options has, sizes that disagree with the file's.
Expected<Checkpoint> read_checkpoint(const std::filesystem::path& path);

/// True for a file that begins as a checkpoint does.
bool is_checkpoint(const std::filesystem::path& path);

/// The scene that a checkpoint has trained so far.
SplatCloud scene_of(const Checkpoint& checkpoint);

}  // namespace fluxgs
