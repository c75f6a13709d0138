// fluxgs render: images of a scene, and how exact they are.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tools/fluxgs/cameras/cameras.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/cameras/path_file.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/core/planar_image.h"
#include "trainer/data/image_io.h"
#include "trainer/loss/photometric.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct RenderSettings {
  std::string scene, out, camera_file, path_file, view, split = "test";
  DataOptions data;
  ImageSize size;
  RendererChoice choice;
  int orbit = 0, sh_degree = 3;  // orbit 0: not given
  double fps = 30;               // of a path
  bool check = false, as_json = false, view_given = false, split_given = false;
};

/// An image to take, and the image taken from the same place if there is one.
struct Shot {
  Camera camera;
  std::optional<View> view;
};

Expected<std::vector<Shot>> shots_of_data(const RenderSettings& s, const Dataset& data) {
  if (s.split == "test" && s.split_given && data.test.empty())
    return fail(s.data.folder, "", "has no test images; --split train shows the others");
  const std::vector<View>& views = s.split == "train" || data.test.empty() ? data.train : data.test;
  std::vector<Shot> shots;
  if (s.view == "all") {
    for (const View& p : views) shots.push_back({resized(p.camera, s.size), p});
  } else {
    std::size_t index = views.size();
    const char* end = s.view.data() + s.view.size();
    if (std::from_chars(s.view.data(), end, index).ptr != end) index = views.size();
    if (index >= views.size())
      return fail(
          s.data.folder, "--view",
          fmt::format("'{}' is not a view, expected 0 to {} or all", s.view, views.size() - 1));
    shots.push_back({resized(views[index].camera, s.size), views[index]});
  }
  if (s.size.width > 0)
    for (Shot& shot : shots) shot.view.reset();  // another size has nothing to be compared with
  return shots;
}

/// The view that fluxgs view begins with, or an orbit from there.
std::vector<Camera> default_cameras(const SceneFile& scene, int orbit, const ImageSize& size) {
  const camera::Navigation first =
      initial_navigation(scene.cloud, scene.start, std::nullopt, std::nullopt, std::nullopt, size)
          .navigation;
  if (orbit > 0) return orbit_through(first, orbit, size);
  return {camera::camera_of(first.view, size.width, size.height)};
}

/// Cameras from the file, along a path, an orbit, or one view.
Expected<std::vector<Camera>> free_cameras(const RenderSettings& s, const SceneFile& scene,
                                           const std::optional<Dataset>& data,
                                           const ImageSize& size) {
  if (!s.camera_file.empty()) return cameras_from_file(s.camera_file, size);
  if (!s.path_file.empty()) {
    const auto path = path_from_file(s.path_file);
    if (!path) return std::unexpected(path.error());
    return cameras_along(*path, s.fps, size);
  }
  if (data) return orbit_along(data->train, std::max(s.orbit, 1), size);
  return default_cameras(scene, s.orbit, size);
}

Expected<std::vector<Shot>> free_shots(const RenderSettings& s, const SceneFile& scene,
                                       const std::optional<Dataset>& data) {
  ImageSize size = s.size;
  if (size.width == 0)
    size = data ? ImageSize{data->train[0].camera.width, data->train[0].camera.height}
                : ImageSize{1280, 720};
  auto cameras = free_cameras(s, scene, data, size);
  if (!cameras) return std::unexpected(cameras.error());
  std::vector<Shot> shots;
  for (Camera& camera : *cameras) shots.push_back({std::move(camera), std::nullopt});
  return shots;
}

/// OUT.png for one image; OUT_000.png, … for several, or OUT_<name>.png with --camera.
std::string file_name(const RenderSettings& s, const std::vector<Shot>& shots, std::size_t i) {
  if (shots.size() == 1) return s.out;
  const std::filesystem::path path(s.out);
  const std::string tag = s.camera_file.empty() ? fmt::format("{:03}", i) : shots[i].camera.name;
  return (path.parent_path() /
          fmt::format("{}_{}{}", path.stem().string(), tag, path.extension().string()))
      .string();
}

/// An error if an image would take the place of an image.
Expected<void> check_views_stay(const RenderSettings& s, const std::vector<Shot>& shots,
                                const Dataset& data) {
  std::error_code ignored;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const std::string file = file_name(s, shots, i);
    for (const auto* views : {&data.train, &data.test})
      for (const View& view : *views)
        if (std::filesystem::equivalent(file, view.path, ignored))
          return fail(file, "", "is an image of the data set; expected another name for the image");
  }
  return {};
}

Expected<std::vector<Shot>> choose_shots(const RenderSettings& s, const SceneFile& scene) {
  std::optional<Dataset> data;
  if (!s.data.folder.empty()) {
    auto loaded = load(s.data);
    if (!loaded) return std::unexpected(loaded.error());
    data = std::move(*loaded);
  }
  auto shots = data && s.view_given ? shots_of_data(s, *data) : free_shots(s, scene, data);
  if (!shots || !data) return shots;
  if (auto ok = check_views_stay(s, *shots, *data); !ok) return std::unexpected(ok.error());
  return shots;
}

/// Renders, writes and measures one image.
Expected<json> take(const Shot& shot, const std::string& file, const ViewRenderer& render,
                    const std::optional<ViewRenderer>& reference, const Threads& threads) {
  const auto image = render(shot.camera);
  if (!image) return std::unexpected(image.error());
  if (auto written = write_png(file, interleaved(*image)); !written)
    return std::unexpected(written.error());
  json entry = {
      {"file", file}, {"name", shot.camera.name}, {"size", {image->width(), image->height()}}};
  if (shot.view) {
    PlanarImage target;
    to_planar(shot.view->rgb, threads, target);
    entry["psnr"] = psnr(*image, target, shot.view->used);
  }
  if (reference) {
    const auto exact = (*reference)(shot.camera);
    if (!exact) return std::unexpected(exact.error());
    entry["reference_psnr"] = psnr(*image, *exact);
    entry["reference_max_error"] = largest_difference(*image, *exact);
  }
  return entry;
}

void print_entry(const json& entry) {
  std::string line = fmt::format("{}", entry["file"].get<std::string>());
  if (entry.contains("psnr"))
    line += fmt::format("  {:.2f} dB to the photo", entry["psnr"].get<double>());
  if (entry.contains("reference_psnr"))
    line += fmt::format("  {:.2f} dB to the float64 reference, largest error {:.5f}",
                        entry["reference_psnr"].get<double>(),
                        entry["reference_max_error"].get<double>());
  fmt::print("{}\n", line);
}

double mean_of(const json& images, const char* key) {
  double total = 0;
  for (const json& p : images) total += p[key].get<double>();
  return total / static_cast<double>(images.size());
}

Expected<void> render(const RenderSettings& s) {
  if (std::filesystem::path(s.out).extension() != ".png")
    return fail(s.out, "", "images are written as PNG, expected a name that ends in .png");
  const auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  const auto shots = choose_shots(s, *scene);
  if (!shots) return std::unexpected(shots.error());

  const Threads threads(s.data.threads);
  RenderOptions options;
  options.background = s.data.background_color();
  options.sh_degree = s.sh_degree;
  RendererChoice choice = s.choice;
  choice.renderer = renderer_for(s.choice);
  const auto renderer = make_renderer(choice, scene->cloud, options, threads);
  if (!renderer) return std::unexpected(renderer.error());
  std::optional<ViewRenderer> reference;
  if (s.check)
    reference = *make_renderer({.renderer = "reference"}, scene->cloud, options, threads);

  json images = json::array();
  // Otherwise the lines of the images show how it goes
  const ProgressReport progress = s.as_json ? show_progress("images") : ProgressReport();
  for (std::size_t i = 0; i < shots->size(); ++i) {
    const auto entry = take((*shots)[i], file_name(s, *shots, i), *renderer, reference, threads);
    if (!entry) return std::unexpected(entry.error());
    images.push_back(*entry);
    if (progress) progress(i + 1, shots->size());
    if (!s.as_json) print_entry(*entry);
  }
  json result = {{"renderer", choice.renderer}, {"images", images}};
  if (s.check) {
    double worst = 0;
    for (const json& p : images) worst = std::max(worst, p["reference_max_error"].get<double>());
    result["reference_psnr"] = mean_of(images, "reference_psnr");
    result["reference_max_error"] = worst;
  }
  if (s.as_json)
    print_json(result);
  else if (s.check)
    fmt::print("mean {:.2f} dB to the float64 reference, largest error {:.5f}\n",
               result["reference_psnr"].get<double>(), result["reference_max_error"].get<double>());
  return {};
}

}  // namespace

void add_render(CLI::App& app, Action& action) {
  auto s = std::make_shared<RenderSettings>();
  CLI::App* command = app.add_subcommand("render", "Render images of a scene");
  command->footer(
      "Views come from --data and --view, from --camera, --path or --orbit. Without any of them:\n"
      "the scene's initial view, or one that shows all of it.\n"
      "Example: fluxgs render garden.glb -o garden.png\n"
      "Example: fluxgs render garden.glb --data captures/garden --view 0 -o view.png\n"
      "Example: fluxgs render garden.glb --data captures/garden --orbit 8 -o orbit.png\n"
      "Example: fluxgs render garden.glb --path settings.json --fps 30 -o frames/frame.png");
  command->add_option("scene", s->scene, "the scene file")->required();
  command
      ->add_option("-o,--out", s->out,
                   "the PNG to write; several become OUT_000.png and so on, or OUT_<name>.png with "
                   "--camera")
      ->required();
  CLI::Option* data = command->add_option("--data", s->data.folder,
                                          "a data set: its views, or an orbit along them");
  CLI::Option* view =
      command->add_option("--view", s->view, "index of an image of the split, or all");
  CLI::Option* orbit = command
                           ->add_option("--orbit", s->orbit,
                                        "number of views around the scene, or with --data\n"
                                        "along the arc that its images cover")
                           ->check(whole_in(1, 10000));
  CLI::Option* camera = command->add_option(
      "--camera", s->camera_file, "JSON list of {name, position, target, up, fovY in degrees}");
  CLI::Option* path = command->add_option(
      "--path", s->path_file,
      "the frames of a camera path: SuperSplat's settings.json, or cameras as --camera takes them");
  command->add_option("--fps", s->fps, "frames of the path a second")
      ->check(in_range(0.1, 240))
      ->needs(path)
      ->capture_default_str();
  view->excludes(orbit)->excludes(camera)->excludes(path)->needs(data);
  orbit->excludes(camera)->excludes(path);
  path->excludes(camera);
  add_split_option(*command, s->split);
  add_data_options(*command, s->data);
  add_size_option(*command, s->size, "WIDTHxHEIGHT (default: the images', otherwise 1280x720)");
  add_renderer_options(*command, s->choice);
  command->add_option("--format", s->choice.format, "image format of gles: rgba8 or rgba16f")
      ->check(CLI::IsMember(kFormatNames))
      ->capture_default_str();
  command->add_option("--sh-degree", s->sh_degree, "highest SH degree to evaluate")
      ->check(whole_in(0, 3));
  command->add_flag("--check", s->check, "measure each image against the float64 reference (slow)");
  command->add_flag("--json", s->as_json, "print one JSON object");
  command->callback([s, view, command, &action] {
    s->view_given = view->count() > 0;
    s->split_given = command->count("--split") > 0;
    action = [s] { return render(*s); };
  });
}

}  // namespace fluxgs::cli
