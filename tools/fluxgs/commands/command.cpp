#include "tools/fluxgs/commands/command.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "fluxgs/io/file.h"
#include "tools/fluxgs/commands/meant_scene.h"
#include "tools/fluxgs/options/method_options.h"
#include "trainer/train/checkpoint.h"

namespace fluxgs::cli {

std::vector<std::string> plain_words(std::vector<std::string> words) {
  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    words.emplace_back("--help");
  }
  if (!words.empty() && words.front() == "train") return with_switches_on(std::move(words));
  return words;
}

std::string switch_before(const std::vector<std::string>& words, const std::string& word) {
  const auto at = std::ranges::find(words, word);
  if (at == words.end() || at == words.begin()) return "";
  const std::string& before = *(at - 1);
  return before.starts_with("--") && before.ends_with("=on") ? before.substr(0, before.size() - 3)
                                                             : "";
}

Expected<SceneFile> read_scene_or_checkpoint(const std::string& given) {
  const auto meant = meant_scene(given);
  if (!meant) return std::unexpected(meant.error());
  const std::string& path = *meant;
  if (!is_checkpoint(path)) return read_scene(path);
  const auto checkpoint = read_checkpoint(path);
  if (!checkpoint) return std::unexpected(checkpoint.error());
  std::error_code ignored;
  SceneFile scene;
  scene.cloud = scene_of(*checkpoint);
  scene.format = "checkpoint";
  scene.warnings.push_back(fmt::format("a training, at iteration {} of {}",
                                       checkpoint->state.iteration,
                                       checkpoint->options.iterations));
  scene.attribute_bits = float_attribute_bits(scene.cloud.sh_degree);
  scene.bytes = std::filesystem::file_size(path, ignored);
  scene.start = checkpoint->start;
  return scene;
}

void warn_of(const std::string& path, const SceneFile& scene) {
  for (const std::string& warning : scene.warnings) spdlog::warn("warning: {}: {}", path, warning);
  if (scene.dropped > 0)
    spdlog::warn("warning: {}: {} splats with NaN or infinity left out", path, scene.dropped);
  if (scene.cloud.size() == 0) spdlog::warn("warning: {}: has no splats", path);
}

Expected<SceneFile> load_scene(const std::string& path) {
  auto scene = read_scene_or_checkpoint(path);
  if (scene) warn_of(path, *scene);
  return scene;
}

void warn_of_lost_degrees(const std::string& path, const SceneFormat& format, int sh_degree) {
  if (sh_degree <= format.max_sh_degree) return;
  spdlog::warn(
      "warning: {}: a {} stores spherical harmonics up to degree {}; those up to {} are "
      "left out",
      path, format.extension, format.max_sh_degree, sh_degree);
}

Expected<std::size_t> write_glb(const std::string& path, const std::vector<std::byte>& glb,
                                const std::optional<InitialView>& initial) {
  const auto file =
      initial ? with_initial_view(glb, *initial, path) : Expected<std::vector<std::byte>>(glb);
  if (!file) return std::unexpected(file.error());
  if (auto written = write_file_atomic(path, *file); !written)
    return std::unexpected(written.error());
  return file->size();
}

}  // namespace fluxgs::cli
