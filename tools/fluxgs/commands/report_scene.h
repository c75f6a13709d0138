// The scene that a report is of, and how near other versions of it are to it.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "tools/fluxgs/commands/lpips.h"
#include "tools/fluxgs/options/data_options.h"
#include "trainer/compress/scene_error.h"
#include "trainer/core/parallel.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

/// A scene with one splat or more, and the data set beside it, if one was given.
struct ReportScene {
  SceneFile scene;
  std::optional<Dataset> data;

  const Dataset* views() const { return data ? &*data : nullptr; }  ///< null: none
};

/// Reads both; bands above `sh_degree` (0…3) are dropped. Errors: a file cannot be read, or the
/// scene has no splats.
Expected<ReportScene> load_report_scene(const std::string& path, int sh_degree,
                                        const DataOptions& data);

/// The option --lpips: which network a report measures LPIPS by.
void add_report_lpips(CLI::App& command, std::string& network);

/// That network; none where none is named. Errors: it is not installed, or `scene` came without
/// test images.
Expected<std::optional<Lpips>> load_report_lpips(const std::string& network,
                                                 const ReportScene& scene, const DataOptions& data,
                                                 const Threads& threads);

struct SceneQuality {
  double psnr = 0;                       ///< to the images of the whole scene, dB
  std::optional<double> view_psnr;       ///< to the test images, dB; none: there are none
  std::optional<LpipsError> view_lpips;  ///< to the test images; none: not asked for

  std::string lpips_cell() const;  ///< of a table, [0,1]; empty where there is none
};

/// "psnr", "view_psnr" and "view_lpips" (both ranges), null where there are none, for a row.
void add_quality(const SceneQuality& quality, nlohmann::json& row);

/// Measures versions of one scene, on views of the data set or of an orbit.
class QualityBench {
 public:
  /// `data` (may be null) and `threads` must outlive this.
  QualityBench(const SplatCloud& whole, const Dataset* data, std::optional<Lpips> lpips,
               const RenderOptions& options, const Threads& threads);

  const SceneError& error() const { return error_; }
  Expected<SceneQuality> measure(const SplatCloud& cloud) const;

 private:
  const Dataset* data_;
  std::optional<Lpips> lpips_;
  RenderOptions options_;
  const Threads& threads_;
  SceneError error_;
};

}  // namespace fluxgs::cli
