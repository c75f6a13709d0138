#include "trainer/data/run_colmap.h"

#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "fluxgs/byte_reader.h"
#include "trainer/core/process.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// One step of the reconstruction: its command, and the option that keeps it off the GPU (COLMAP
/// needs a display or CUDA there), which COLMAP 3.12 renamed.
struct Step {
  std::string command;
  std::vector<std::string> arguments;
  std::vector<std::string> cpu_options;  // tried in order; empty: none needed
};

Expected<void> run_step(const fs::path& colmap, const Step& step, const fs::path& log) {
  spdlog::info("running colmap {} (log: {})", step.command, log.string());
  std::vector<std::string> arguments{step.command};
  arguments.insert(arguments.end(), step.arguments.begin(), step.arguments.end());
  if (step.cpu_options.empty() && run({colmap, arguments, log}) == 0) return {};
  for (const std::string& option : step.cpu_options) {
    auto with_option = arguments;
    with_option.insert(with_option.end(), {option, "0"});
    if (run({colmap, with_option, log}) == 0) return {};
  }
  return fail(log.string(), "", fmt::format("colmap {} failed; this log says why", step.command));
}

std::vector<Step> reconstruction_steps(const std::string& images, const std::string& database,
                                       const std::string& sparse) {
  return {{"feature_extractor",
           {"--database_path", database, "--image_path", images, "--ImageReader.single_camera", "1",
            "--ImageReader.camera_model", "OPENCV"},
           {"--SiftExtraction.use_gpu", "--FeatureExtraction.use_gpu"}},
          {"exhaustive_matcher",
           {"--database_path", database},
           {"--SiftMatching.use_gpu", "--FeatureMatching.use_gpu"}},
          {"mapper",
           {"--database_path", database, "--image_path", images, "--output_path", sparse},
           {}}};
}

/// A work folder without traces of an earlier, interrupted run.
Expected<void> prepare(const fs::path& work_folder, const fs::path& partial) {
  std::error_code error;
  fs::create_directories(work_folder, error);
  if (error) return fail(work_folder.string(), "", "cannot be created: " + error.message());
  fs::remove(work_folder / "database.db", error);
  fs::remove(work_folder / "log.txt", error);
  fs::remove_all(partial, error);
  fs::create_directories(partial, error);
  if (error) return fail(partial.string(), "", "cannot be created: " + error.message());
  return {};
}

}  // namespace

Expected<void> run_colmap(const fs::path& images, const fs::path& work_folder) {
  const auto colmap = find_program("colmap");
  if (!colmap)
    return fail(images.string(), "",
                "images without camera poses (no sparse/0, no transforms.json); install COLMAP "
                "to recover the poses (apt install colmap) or give a folder that has them");
  const fs::path partial = work_folder / "sparse.partial", log = work_folder / "log.txt";
  if (const auto ok = prepare(work_folder, partial); !ok) return ok;
  for (const Step& step : reconstruction_steps(
           images.string(), (work_folder / "database.db").string(), partial.string()))
    if (const auto ok = run_step(*colmap, step, log); !ok) return ok;
  if (colmap_models(partial).empty())
    return fail(log.string(), "",
                "COLMAP found no cameras; expected sharp images that overlap, from many sides");
  std::error_code error;
  fs::rename(partial, work_folder / "sparse", error);
  if (error) return fail(partial.string(), "", "cannot be renamed: " + error.message());
  return {};
}

}  // namespace fluxgs
