#include "tools/fluxgs/commands/report_scene.h"

#include <utility>

#include <fmt/format.h>

#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"
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

void add_report_lpips(CLI::App& command, std::string& network) {
  command
      .add_option("--lpips", network,
                  "also measure LPIPS against the test images, by vgg (which papers print) or "
                  "alex,\nwith values in [0,1]; --json has both ranges (tools/deps/lpips installs "
                  "them)")
      ->check(CLI::IsMember({"vgg", "alex"}));
}

Expected<std::optional<Lpips>> load_report_lpips(const std::string& network,
                                                 const ReportScene& scene, const DataOptions& data,
                                                 const Threads& threads) {
  if (network.empty()) return std::nullopt;
  if (!scene.data || scene.data->test.empty())
    return fail(data.folder, "--lpips",
                "there are no test images; expected --data with images that training did not see");
  auto loaded = Lpips::load(network, threads.count());
  if (!loaded) return std::unexpected(loaded.error());
  return std::move(*loaded);
}

std::string SceneQuality::lpips_cell() const {
  return view_lpips ? fmt::format("{:.4f}", view_lpips->zero_to_one) : "";
}

void add_quality(const SceneQuality& quality, nlohmann::json& row) {
  row["psnr"] = finite_or_null(quality.psnr);
  row["view_psnr"] = quality.view_psnr ? nlohmann::json(*quality.view_psnr) : nullptr;
  row["view_lpips"] = nullptr;
  if (quality.view_lpips)
    row["view_lpips"] = {{"zero_to_one", quality.view_lpips->zero_to_one},
                         {"minus_one_to_one", quality.view_lpips->minus_one_to_one}};
}

QualityBench::QualityBench(const SplatCloud& whole, const Dataset* data, std::optional<Lpips> lpips,
                           const RenderOptions& options, const Threads& threads)
    : data_(data),
      lpips_(std::move(lpips)),
      options_(options),
      threads_(threads),
      error_(whole, evaluation_cameras(whole, data), options, threads) {}

Expected<SceneQuality> QualityBench::measure(const SplatCloud& cloud) const {
  const auto mse = error_.mse(cloud);
  if (!mse) return std::unexpected(mse.error());
  SceneQuality quality{.psnr = psnr_of_mse(*mse), .view_psnr = {}, .view_lpips = {}};
  if (data_ == nullptr || data_->test.empty()) return quality;
  const ViewRenderer renderer = cpu_view_renderer(cloud, options_, threads_);
  const auto score = evaluate(data_->test, renderer, threads_);
  if (!score) return std::unexpected(score.error());
  quality.view_psnr = score->psnr;
  if (!lpips_) return quality;
  const auto errors = lpips_errors(data_->test, renderer, *lpips_, show_progress("LPIPS"));
  if (!errors) return std::unexpected(errors.error());
  quality.view_lpips = mean_of(*errors);
  return quality;
}

}  // namespace fluxgs::cli
