// fluxgs eval: a scene against images.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/flip.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/data/image_header.h"

namespace fluxgs::cli {
namespace {

struct EvalSettings {
  std::string scene, split = "test";
  DataOptions data;
  RendererChoice choice{.renderer = "cpu"};
  bool as_json = false, flip = false, downscale_given = false;
};

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// `flip`: of each view, or empty.
nlohmann::json to_json(const Evaluation& score, const std::vector<double>& flip,
                       const SceneFile& scene) {
  nlohmann::json views = nlohmann::json::array();
  for (const ViewScore& v : score.views)
    views.push_back({{"name", v.name}, {"psnr", v.psnr}, {"ssim", v.ssim}});
  for (std::size_t i = 0; i < flip.size(); ++i) views[i]["flip"] = flip[i];
  nlohmann::json object = {{"psnr", score.psnr},
                           {"ssim", score.ssim},
                           {"views", views},
                           {"splats", scene.cloud.size()},
                           {"bytes", scene.bytes}};
  if (!flip.empty()) object["flip"] = mean_of(flip);
  return object;
}

void print_scores(const Evaluation& score, const std::vector<double>& flip,
                  const SceneFile& scene) {
  const auto shown = [](double error) { return fmt::format("  FLIP {:.4f}", error); };
  for (std::size_t i = 0; i < score.views.size(); ++i) {
    const ViewScore& v = score.views[i];
    fmt::print("{:<32} {:6.2f} dB  SSIM {:.4f}{}\n", v.name, v.psnr, v.ssim,
               flip.empty() ? "" : shown(flip[i]));
  }
  fmt::print("{:<32} {:6.2f} dB  SSIM {:.4f}{}  ({} splats, {} bytes)\n", "mean", score.psnr,
             score.ssim, flip.empty() ? "" : shown(mean_of(flip)), scene.cloud.size(), scene.bytes);
}

/// The images at the size that the scene was trained with, where it tells.
Expected<Dataset> as_trained(DataOptions options, Dataset data, const SceneFile& scene) {
  if (!scene.start || scene.start->image_width == 0 || data.train.empty()) return data;
  const Camera& camera = data.train[0].camera;
  const int loaded = std::max(camera.width, camera.height);
  const int trained = std::max(scene.start->image_width, scene.start->image_height);
  // The size of the files says how they were reduced; they were cut by little
  const auto file = read_file(data.train[0].path);
  const auto header = file ? parse_image_header(*file) : std::nullopt;
  const double all = header && header->width > 0
                         ? static_cast<double>(std::max(header->width, header->height))
                         : loaded;
  const int downscale = static_cast<int>(std::round(all / trained));
  if (std::abs(loaded - trained) <= loaded / 10 || downscale < 1) return data;
  options.downscale = downscale;
  spdlog::info("{}: images reduced by {}, as the scene was trained (--downscale 1 for all pixels)",
               options.folder, downscale);
  return load(options);
}

Expected<void> eval(const EvalSettings& s) {
  if (s.flip)
    if (auto ok = check_flip(); !ok) return ok;
  const auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  auto data = load(s.data);
  if (data && !s.downscale_given) data = as_trained(s.data, std::move(*data), *scene);
  if (!data) return std::unexpected(data.error());
  const std::vector<View>& views = s.split == "train" ? data->train : data->test;
  if (views.empty())
    return fail(s.data.folder, "",
                s.split == "train" ? "has no training images; --split test measures the others"
                                   : "has no test images; --split train measures those that "
                                     "the scene was trained on");

  const Threads threads(s.data.threads);
  RenderOptions options;
  options.background = s.data.background_color();
  const auto renderer = make_renderer(s.choice, scene->cloud, options, threads);
  if (!renderer) return std::unexpected(renderer.error());
  const auto score = evaluate(views, *renderer, threads, show_progress("views"));
  if (!score) return std::unexpected(score.error());

  std::vector<double> flip;
  if (s.flip) {
    auto errors = flip_errors(views, *renderer, show_progress("views"));
    if (!errors) return std::unexpected(errors.error());
    flip = std::move(*errors);
  }

  if (s.as_json)
    print_json(to_json(*score, flip, *scene));
  else
    print_scores(*score, flip, *scene);
  return {};
}

}  // namespace

void add_eval(CLI::App& app, Action& action) {
  auto s = std::make_shared<EvalSettings>();
  CLI::App* command = app.add_subcommand("eval", "Measure a scene against images: PSNR and SSIM");
  command->footer("Example: fluxgs eval garden.glb --data captures/garden --downscale 2 --json");
  command->add_option("scene", s->scene, "the scene file")->required();
  command->add_option("--data", s->data.folder, "the data set with the images")->required();
  add_split_option(*command, s->split);
  add_data_options(*command, s->data);
  add_masks_option(*command, s->data.masks);
  add_renderer_options(*command, s->choice);
  command->add_flag("--flip", s->flip, "also measure FLIP, 0 to 1 (tools/deps/flip installs it)");
  command->add_flag("--json", s->as_json, "print one JSON object");
  command->callback([s, command, &action] {
    s->downscale_given = command->count("--downscale") > 0;
    action = [s] { return eval(*s); };
  });
}

}  // namespace fluxgs::cli
