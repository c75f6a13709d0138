#include "tools/fluxgs/command.h"

#include <cstdio>
#include <span>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {

Expected<SceneFile> load_scene(const std::string& path) {
  auto scene = read_scene(path);
  if (!scene) return scene;
  if (scene->dropped > 0)
    spdlog::warn("warning: {}: {} splats with NaN or infinity left out", path, scene->dropped);
  if (scene->cloud.size() == 0) spdlog::warn("warning: {}: has no splats", path);
  return scene;
}

void warn_of_lost_degrees(const std::string& path, const SceneFormat& format, int sh_degree) {
  if (sh_degree <= format.max_sh_degree) return;
  spdlog::warn(
      "warning: {}: a {} stores spherical harmonics up to degree {}; those up to {} are "
      "left out",
      path, format.extension, format.max_sh_degree, sh_degree);
}

CLI::Validator in_range(double least, double most) {
  const std::string name = fmt::format("in [{} - {}]", least, most);
  return {[=](const std::string& text) {
            double value = 0;
            const bool number = CLI::detail::lexical_cast(text, value);
            if (number && value >= least && value <= most) return std::string();  // not for NaN
            return fmt::format("{} is not a number {}", text, name);
          },
          "FLOAT:" + name};
}

namespace {

/// Names of files need not be UTF-8: what is not becomes U+FFFD.
std::string text_of(const nlohmann::json& object) {
  return object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

void print_json(const nlohmann::json& object) { fmt::print("{}", text_of(object)); }

Expected<void> write_json(const std::string& path, const nlohmann::json& object) {
  const std::string text = text_of(object);
  return write_file_atomic(path, std::as_bytes(std::span(text)));
}

}  // namespace fluxgs::cli
