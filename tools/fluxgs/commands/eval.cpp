// fluxgs eval: a scene against images.
#include <algorithm>
#include <numeric>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/flip.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"

namespace fluxgs::cli {
namespace {

struct EvalSettings {
  std::string scene, split = "test";
  DataOptions data;
  RendererChoice choice{.renderer = "cpu"};
  bool as_json = false, flip = false;
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

/// The longer side of the images that the scene was trained with; 0: not known.
int trained_side(const SceneFile& scene) {
  return scene.start ? std::max(scene.start->image_width, scene.start->image_height) : 0;
}

Expected<void> eval(const EvalSettings& s) {
  if (s.flip)
    if (auto ok = check_flip(); !ok) return ok;
  const auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  DataOptions options_of_data = s.data;
  options_of_data.trained_side = trained_side(*scene);
  const auto data = load(options_of_data);
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
  command->callback([s, &action] { action = [s] { return eval(*s); }; });
}

}  // namespace fluxgs::cli
