// The scene that a report is of, and how near other versions of it are to it.
#pragma once

#include <optional>
#include <string>

#include "fluxgs/error.h"
#include "fluxgs/io/file.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
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

/// Two PSNR in dB.
struct SceneQuality {
  double psnr = 0;                  ///< to the images of the whole scene
  std::optional<double> view_psnr;  ///< to the test images; none: there are none
};

/// Measures versions of one scene, on views of the data set or of an orbit.
class QualityBench {
 public:
  /// `data` (may be null) and `threads` must outlive this.
  QualityBench(const SplatCloud& whole, const Dataset* data, const RenderOptions& options,
               const Threads& threads);

  const SceneError& error() const { return error_; }
  Expected<SceneQuality> measure(const SplatCloud& cloud) const;

 private:
  const Dataset* data_;
  RenderOptions options_;
  const Threads& threads_;
  SceneError error_;
};

}  // namespace fluxgs::cli
