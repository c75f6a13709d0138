// fluxgs doctor: what this machine has.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <draco/core/draco_version.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/version.h>
#include <zstd.h>
#include <CLI/CLI.hpp>
#include <CLI/Version.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

#include "bench/driver_check.h"
#include "fluxgs/networks/onnx_runtime.h"
#include "fluxgs/sanitize.h"
#include "platform/host/host_context.h"
#include "platform/host/window_screen.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/flip.h"
#include "tools/fluxgs/commands/lpips.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/reference/reference_renderer.h"
#include "trainer/core/isa.h"
#include "trainer/core/process.h"
#include "trainer/data/heif.h"
#include "trainer/data/photos/work_folder.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

/// A shell of splats of all shapes and opacities, the view from outside and its picture.
struct KnownScene {
  SplatCloud cloud;
  Camera camera;
  RenderOptions options = {};
  Image<std::uint8_t> picture = {};
};

KnownScene known_scene() {
  constexpr std::size_t kSplats = 800;
  constexpr int kSize = 160;
  KnownScene scene;
  SplatCloud& cloud = scene.cloud;
  cloud.sh_degree = 0;
  cloud.resize(kSplats);
  for (std::size_t i = 0; i < kSplats; ++i) {
    const double t = (static_cast<double>(i) + 0.5) / kSplats, turn = 2.4 * static_cast<double>(i);
    const double z = 1 - 2 * t, radius = std::sqrt(1 - z * z);
    const glm::dvec3 wave = {std::sin(turn), std::cos(3 * turn), std::sin(7 * turn)};
    cloud.positions[i] = {radius * std::cos(turn), radius * std::sin(turn), z};
    cloud.log_scales[i] = glm::vec3(-3.0 + 0.8 * wave);
    cloud.rotations[i] = glm::normalize(glm::quat(1, glm::vec3(wave)));
    cloud.opacity_logits[i] = static_cast<float>(2 * wave.z);
    cloud.sh_dc[i] = glm::vec3(wave);
  }
  Camera& camera = scene.camera;
  camera.width = camera.height = kSize;
  camera.fx = camera.fy = kSize;
  camera.cx = camera.cy = 0.5 * kSize;
  camera.translation = {0, 0, 3};
  scene.picture = in_bytes(render_reference(cloud, camera, scene.options).color);
  return scene;
}

/// The check of an OpenGL by the known scene (bench::to_json()).
json picture_of(gl::Api& api) {
  static const KnownScene scene = known_scene();
  return json::parse(bench::to_json(
      bench::check_driver(api, scene.cloud, scene.camera, scene.options.near_plane, scene.picture),
      api));
}

std::string line_of(const json& picture) {
  if (!picture["right"].get<bool>())
    return "draws wrong pictures: " + picture["faults"].front().get<std::string>();
  const auto limits = picture["limits"].get<std::vector<std::string>>();
  return fmt::format("draws right ({:.0f} dB{}{})", picture["psnr"].get<double>(),
                     limits.empty() ? "" : ", ", fmt::join(limits, ", "));
}

json gl_implementations() {
  json all = json::object();
  for (const std::string& name : kGlNames) {
    const auto context = host::HostContext::create(*host::parse_host_gl(name));
    if (!context) {
      all[name] = {{"available", false}, {"reason", context.error().message()}};
      continue;
    }
    const gl::Capabilities& c = (*context)->api().capabilities;
    all[name] = {{"available", true},
                 {"renderer", c.renderer},
                 {"version", c.version},
                 {"picture", picture_of((*context)->api())}};
  }
  return all;
}

json windows() {
  const auto version = host::window_library_version();
  if (!version) return {{"available", false}, {"reason", version.error().message()}};
  return {{"available", true}, {"version", *version}};
}

json program_path(const std::string& name) {
  const auto found = find_program(name);
  return found ? json(*found) : json(nullptr);
}

json onnxruntime() {
  const auto info = networks::onnx_runtime_info();
  if (!info) return {{"available", false}, {"reason", info.error().message()}};
  return {{"available", true}, {"version", info->version}, {"path", info->path}};
}

json flip() {
  const auto there = check_flip();
  if (!there) return {{"available", false}, {"reason", there.error().message()}};
  return {{"available", true}};
}

json lpips() {
  for (const char* network : {"vgg", "alex"})
    if (const auto there = Lpips::load(network, 1); !there)
      return {{"available", false}, {"reason", there.error().message()}};
  return {{"available", true}};
}

/// Reduced photos and poses that are kept for a next time.
json work_kept() {
  const auto folder = work_folders();
  if (!folder) return nullptr;
  std::uintmax_t bytes = 0;
  walk_folder(*folder, [&](const std::filesystem::directory_entry& entry, int) {
    std::error_code ignored;
    const std::uintmax_t size = entry.is_regular_file(ignored) ? entry.file_size(ignored) : 0;
    if (!ignored) bytes += size;
    return true;
  });
  return {{"path", folder->string()}, {"bytes", bytes}};
}

json examine() {
  json sets = json::array();
  for (Isa isa : available_isas()) sets.push_back(name_of(isa));
  return {{"fluxgs", FLUXGS_VERSION},
          {"cores", std::thread::hardware_concurrency()},
          {"instruction_sets", sets},
          {"gl", gl_implementations()},
          {"glfw", windows()},
          {"cuda", {{"available", false}, {"reason", "this build has no CUDA backend"}}},
          {"colmap", program_path("colmap")},
          {"ffmpeg", program_path("ffmpeg")},
          {"libheif", has_libheif()},
          {"gnuplot", program_path("gnuplot")},
          {"onnxruntime", onnxruntime()},
          {"flip", flip()},
          {"lpips", lpips()},
          {"work_kept", work_kept()},
          {"versions",
           {{"compiler", __VERSION__},
            {"opencv", CV_VERSION},
            {"onetbb", fmt::format("{}.{}", TBB_VERSION_MAJOR, TBB_VERSION_MINOR)},
            {"draco", draco::kDracoVersion},
            {"zstd", ZSTD_versionString()},
            {"cli11", CLI11_VERSION}}}};
}

void print_doctor(const json& found) {
  fmt::print("fluxgs {}\n", found["fluxgs"].get<std::string>());
  fmt::print("processor   {} cores, kernels for", found["cores"].get<unsigned>());
  for (const json& set : found["instruction_sets"]) fmt::print(" {}", set.get<std::string>());
  fmt::print("\n");
  for (const auto& [name, gl] : found["gl"].items())
    fmt::print("GL {:<8} {}\n", name,
               gl["available"].get<bool>()
                   ? fmt::format("{}, {}; {}", gl["renderer"].get<std::string>(),
                                 gl["version"].get<std::string>(), line_of(gl["picture"]))
                   : "missing: " + gl["reason"].get<std::string>());
  const json& glfw = found["glfw"];
  fmt::print("GLFW        {}\n", glfw["available"].get<bool>()
                                     ? glfw["version"].get<std::string>()
                                     : "missing: " + glfw["reason"].get<std::string>());
  fmt::print("CUDA        {}\n", found["cuda"]["reason"].get<std::string>());
  fmt::print("COLMAP      {}\n", found["colmap"].is_null()
                                     ? "not found; needed only for images without poses"
                                     : found["colmap"].get<std::string>());
  fmt::print("ffmpeg      {}\n", found["ffmpeg"].is_null() ? "not found; needed only for videos"
                                                           : found["ffmpeg"].get<std::string>());
  fmt::print("libheif     {}\n", found["libheif"].get<bool>()
                                     ? "there"
                                     : "not found; needed only for HEIC and AVIF photos");
  fmt::print("gnuplot     {}\n", found["gnuplot"].is_null()
                                     ? "not found; needed only for the charts of fluxgs report"
                                     : found["gnuplot"].get<std::string>());
  const json& onnx = found["onnxruntime"];
  fmt::print("onnxruntime {}\n",
             onnx["available"].get<bool>()
                 ? onnx["version"].get<std::string>() + " (" + onnx["path"].get<std::string>() + ")"
                 : "missing: " + onnx["reason"].get<std::string>());
  for (const auto& [name, key] : {std::pair("FLIP", "flip"), std::pair("LPIPS", "lpips")}) {
    const json& measure = found[key];
    fmt::print("{:<11} {}\n", name,
               measure["available"].get<bool>()
                   ? "there"
                   : "not usable: " + measure["reason"].get<std::string>());
  }
  const json& work = found["work_kept"];
  if (!work.is_null() && work["bytes"].get<std::uintmax_t>() > 0)
    fmt::print("work kept   {:.0f} MB of photos and poses in {}; delete it when you are done\n",
               1e-6 * static_cast<double>(work["bytes"].get<std::uintmax_t>()),
               one_line(work["path"].get<std::string>()));
  for (const auto& [name, version] : found["versions"].items())
    fmt::print("{:<11} {}\n", name, version.get<std::string>());
}

Expected<void> doctor(bool as_json) {
  const json found = examine();
  if (as_json)
    print_json(found);
  else
    print_doctor(found);
  return {};
}

}  // namespace

void add_doctor(CLI::App& app, Action& action) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("doctor", "Check this machine: OpenGL, CUDA, COLMAP, versions");
  command->footer("Example: fluxgs doctor");
  command->add_flag("--json", *as_json, "print one JSON object");
  command->callback([=, &action] { action = [=] { return doctor(*as_json); }; });
}

}  // namespace fluxgs::cli
