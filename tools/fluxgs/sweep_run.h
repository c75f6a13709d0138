// One run of a sweep: a scene trained, stored and measured by children of this program, in a folder
// that remembers what is done.
//
//   run.json       what was done with which options, and what failed
//   log.txt        what the children said
//   train.json     report of the training        scene.glb, scene.glb.ckpt
//   scene.ply      the scene before it was made compact
//   score.json     test images against it        frames.json  its frame times
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"
#include "tools/fluxgs/interrupt.h"

namespace fluxgs::cli {

struct SweepRun {
  std::string data, data_hash;
  std::filesystem::path folder;
  std::string preset;
  std::vector<std::string> options;  ///< of `fluxgs train`, without preset and seed
  nlohmann::json meaning;            ///< training_meaning() of both
  std::uint64_t seed = 1;
  int iterations = 0;  ///< that the training takes
};

/// How finished scenes are stored and measured.
struct SweepMeasures {
  int frames = 30;    ///< for the frame time; 0: not measured
  bool flip = false;  ///< also measure FLIP
};

struct SweepTools {
  std::filesystem::path program;  ///< fluxgs
  const InterruptCounter& interrupts;
  SweepMeasures measures = {};
  bool retry = false;                          ///< also what failed before
  std::function<void(int)> on_iteration = {};  ///< how far the training is, about every second
};

enum class RunState { waiting, finished, failed, interrupted };

struct RunOutcome {
  RunState state = RunState::waiting;
  bool ran = false;                           ///< something was done now; false: it was all there
  std::string error = {};                     ///< of a failed run, one line
  std::vector<std::string> remarks = {};      ///< what could not be measured and why, a line each
  std::string build = {};                     ///< a hash of the program that trained it
  std::map<std::string, double> values = {};  ///< by the keys of sweep_metrics()
  std::vector<std::pair<int, double>> curve = {};  ///< iteration, PSNR of the test images
};

/// Does what is not done yet: trains (from the checkpoint of an interrupted training, if it has the
/// same meaning), stores, scores and times. What was made of other data, by another version or with
/// options that mean something else is put aside (seed-1.old-1, …) and made again. Whatever fails
/// is an outcome, too.
RunOutcome execute_run(const SweepRun& run, const SweepTools& tools);

/// A hash of all files of a data set, by their names and contents; not of hidden ones, and not of
/// what COLMAP makes of the images, which appears with the first training. Errors: not a folder,
/// files that cannot be read.
Expected<std::string> hash_of_data(const std::filesystem::path& folder);

/// A hash of one file.
Expected<std::string> hash_of_file(const std::filesystem::path& file);

}  // namespace fluxgs::cli
