// fluxgs eval: a scene against images.
#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/flip.h"
#include "tools/fluxgs/commands/lpips.h"
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
  std::vector<std::string> lpips;  ///< networks
};

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Measures of each view beside PSNR and SSIM; those that were not asked for are empty.
struct Perceived {
  std::vector<double> flip;
  std::map<std::string, std::vector<LpipsError>> lpips;  ///< by network
};

nlohmann::json to_json(const LpipsError& error) {
  return {{"zero_to_one", error.zero_to_one}, {"minus_one_to_one", error.minus_one_to_one}};
}

nlohmann::json to_json(const Evaluation& score, const Perceived& perceived,
                       const SceneFile& scene) {
  nlohmann::json views = nlohmann::json::array();
  for (const ViewScore& v : score.views)
    views.push_back({{"name", v.name}, {"psnr", v.psnr}, {"ssim", v.ssim}});
  nlohmann::json object = {{"psnr", score.psnr},
                           {"ssim", score.ssim},
                           {"splats", scene.cloud.size()},
                           {"bytes", scene.bytes}};
  for (std::size_t i = 0; i < perceived.flip.size(); ++i) views[i]["flip"] = perceived.flip[i];
  if (!perceived.flip.empty()) object["flip"] = mean_of(perceived.flip);
  for (const auto& [network, errors] : perceived.lpips) {
    for (std::size_t i = 0; i < errors.size(); ++i) views[i]["lpips"][network] = to_json(errors[i]);
    object["lpips"][network] = to_json(mean_of(errors));
  }
  object["views"] = std::move(views);
  return object;
}

std::string shown(const LpipsError& error) {
  return fmt::format("{:.4f} [0,1] {:.4f} [-1,1]", error.zero_to_one, error.minus_one_to_one);
}

void print_scores(const Evaluation& score, const Perceived& perceived, const SceneFile& scene) {
  const auto line = [](const std::string& name, double psnr, double ssim) {
    fmt::print("{:<32} {:6.2f} dB  SSIM {:.4f}", name, psnr, ssim);
  };
  const auto print_flip = [](double error) { fmt::print("  FLIP {:.4f}", error); };
  const auto print_lpips = [](const std::string& network, const LpipsError& error) {
    fmt::print("  LPIPS {} {}", network, shown(error));
  };
  for (std::size_t i = 0; i < score.views.size(); ++i) {
    const ViewScore& v = score.views[i];
    line(v.name, v.psnr, v.ssim);
    if (!perceived.flip.empty()) print_flip(perceived.flip[i]);
    for (const auto& [network, errors] : perceived.lpips) print_lpips(network, errors[i]);
    fmt::print("\n");
  }
  line("mean", score.psnr, score.ssim);
  if (!perceived.flip.empty()) print_flip(mean_of(perceived.flip));
  for (const auto& [network, errors] : perceived.lpips) print_lpips(network, mean_of(errors));
  fmt::print("  ({} splats, {} bytes)\n", scene.cloud.size(), scene.bytes);
}

/// The longer side of the images that the scene was trained with; 0: not known.
int trained_side(const SceneFile& scene) {
  return scene.start ? std::max(scene.start->image_width, scene.start->image_height) : 0;
}

Expected<Perceived> measure_perceived(const EvalSettings& s, const std::vector<View>& views,
                                      const ViewRenderer& renderer,
                                      const std::vector<Lpips>& lpips) {
  Perceived found;
  if (s.flip) {
    auto errors = flip_errors(views, renderer, show_progress("views"));
    if (!errors) return std::unexpected(errors.error());
    found.flip = std::move(*errors);
  }
  for (const Lpips& network : lpips) {
    auto errors = lpips_errors(views, renderer, network, show_progress("views"));
    if (!errors) return std::unexpected(errors.error());
    found.lpips[network.network()] = std::move(*errors);
  }
  return found;
}

Expected<void> eval(const EvalSettings& s) {
  if (s.flip)
    if (auto ok = check_flip(); !ok) return ok;
  const Threads threads(s.data.threads);
  std::vector<Lpips> lpips;
  for (const std::string& network : s.lpips) {
    auto loaded = Lpips::load(network, threads.count());
    if (!loaded) return std::unexpected(loaded.error());
    lpips.push_back(std::move(*loaded));
  }
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

  RenderOptions options;
  options.background = s.data.background_color();
  const auto renderer = make_renderer(s.choice, scene->cloud, options, threads);
  if (!renderer) return std::unexpected(renderer.error());
  const auto score = evaluate(views, *renderer, threads, show_progress("views"));
  if (!score) return std::unexpected(score.error());

  const auto perceived = measure_perceived(s, views, *renderer, lpips);
  if (!perceived) return std::unexpected(perceived.error());
  if (s.as_json)
    print_json(to_json(*score, *perceived, *scene));
  else
    print_scores(*score, *perceived, *scene);
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
  command
      ->add_option("--lpips", s->lpips,
                   "also measure LPIPS by one network or both: vgg (which papers print), alex\n"
                   "(tools/deps/lpips installs them)")
      ->check(CLI::IsMember({"vgg", "alex"}))
      ->expected(1, 2);
  command->add_flag("--json", s->as_json, "print one JSON object");
  command->callback([s, &action] { action = [s] { return eval(*s); }; });
}

}  // namespace fluxgs::cli
