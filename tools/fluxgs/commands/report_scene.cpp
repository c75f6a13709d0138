#include "tools/fluxgs/commands/report_scene.h"

#include <utility>

#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/terminal/console.h"
#include "trainer/core/psnr.h"
#include "trainer/raster/view_renderer.h"
#include "trainer/train/evaluate.h"

namespace fluxgs::cli {

Expected<ReportScene> load_report_scene(const std::string& path, int sh_degree,
                                        const DataOptions& data) {
  auto scene = load_scene(path);
  if (!scene) return std::unexpected(scene.error());
  if (scene->cloud.size() == 0) return fail(path, "", "has no splats; expected a scene to measure");
  limit_sh_degree(scene->cloud, sh_degree);
  auto loaded = load_if_given(data);
  if (!loaded) return std::unexpected(loaded.error());
  return ReportScene{std::move(*scene), std::move(*loaded)};
}

QualityBench::QualityBench(const SplatCloud& whole, const Dataset* data,
                           const RenderOptions& options, const Threads& threads)
    : data_(data),
      options_(options),
      threads_(threads),
      error_(whole, evaluation_cameras(whole, data), options, threads) {}

Expected<SceneQuality> QualityBench::measure(const SplatCloud& cloud) const {
  const auto mse = error_.mse(cloud);
  if (!mse) return std::unexpected(mse.error());
  SceneQuality quality{.psnr = psnr_of_mse(*mse), .view_psnr = {}};
  if (data_ == nullptr || data_->test.empty()) return quality;
  const auto score = evaluate(data_->test, cpu_view_renderer(cloud, options_, threads_), threads_);
  if (!score) return std::unexpected(score.error());
  quality.view_psnr = score->psnr;
  return quality;
}

}  // namespace fluxgs::cli
