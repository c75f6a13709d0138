#include "tools/fluxgs/commands/preview.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "fluxgs/io/gltf.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/commands/command.h"
#include "trainer/core/clock.h"
#include "trainer/data/image_io.h"
#include "trainer/raster/view_renderer.h"

namespace fluxgs::cli {
namespace {

constexpr double kRenewEvery = 3, kMostShare = 0.05;  // seconds; of the time

}  // namespace

std::string preview_folder(const TrainSettings& settings) { return settings.out + ".preview"; }

Preview::Preview(const TrainSettings& settings, const Dataset& data)
    : settings_(settings), data_(data), pictures_(settings.preview_every > 0) {
  if (!settings.preview) return;
  folder_.emplace();
  const std::filesystem::path out(settings.out);
  if (!folder_->path().empty())
    file_ = (folder_->path() / (out.stem().string() + " (training).glb")).string();
}

void Preview::update(const Trainer& trainer) {
  if (!file_.empty() && wall_seconds() >= next_) renew_window(trainer);
  if (pictures_ && trainer.state.iteration % settings_.preview_every == 0) write_picture(trainer);
}

Expected<void> Preview::write_scene_file(const Trainer& trainer) const {
  const auto bytes = encode_glb(trainer.cloud(), file_);
  if (!bytes) return std::unexpected(bytes.error());
  const auto written = write_glb(file_, *bytes, initial_view_of(data_.train));
  return written ? Expected<void>() : std::unexpected(written.error());
}

void Preview::renew_window(const Trainer& trainer) {
  const double start = wall_seconds();
  if (window_ && !window_->runs()) {
    spdlog::info("the window of --preview is closed; the training goes on");
    return file_.clear();
  }
  if (const auto written = write_scene_file(trainer); !written) {
    spdlog::warn("warning: no more previews: {}", written.error().message());
    return file_.clear();
  }
  if (!window_)
    window_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        "view", file_, "--follow", "--background",
        fmt::format("{},{},{}", settings_.data.background[0], settings_.data.background[1],
                    settings_.data.background[2])});
  const double now = wall_seconds();
  next_ = now + std::max(kRenewEvery, (now - start) / kMostShare);
}

void Preview::write_picture(const Trainer& trainer) {
  const std::filesystem::path folder = preview_folder(settings_);
  const ViewRenderer render =
      cpu_view_renderer(trainer.cloud(), trainer.options.render, trainer.threads);
  const auto image = render(middle_of(data_.train).camera);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const auto file = folder / fmt::format("{:06}.png", trainer.state.iteration);
  const auto written = image ? write_png(file.string(), interleaved(*image))
                             : Expected<void>(std::unexpected(image.error()));
  if (written) return;
  spdlog::warn("warning: no more pictures: {}", written.error().message());
  pictures_ = false;
}

}  // namespace fluxgs::cli
