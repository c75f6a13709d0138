// fluxgs eval: a scene against photos.
#include <fmt/format.h>

#include "fluxgs/io/scene.h"
#include "tools/fluxgs/command.h"
#include "tools/fluxgs/renderers.h"

namespace fluxgs::cli {
namespace {

struct EvalSettings {
  std::string scene, data, split = "test";
  RendererChoice choice{.renderer = "cpu"};
  std::vector<double> background{0, 0, 0};
  int downscale = 1, threads = 0;
  bool as_json = false;
};

nlohmann::json to_json(const Evaluation& score, const SceneFile& scene) {
  nlohmann::json views = nlohmann::json::array();
  for (const ViewScore& v : score.views)
    views.push_back({{"name", v.name}, {"psnr", v.psnr}, {"ssim", v.ssim}});
  return {{"psnr", score.psnr},
          {"ssim", score.ssim},
          {"views", views},
          {"splats", scene.cloud.size()},
          {"bytes", scene.bytes}};
}

Expected<void> eval(const EvalSettings& s) {
  const auto scene = read_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  LoadOptions load;
  load.downscale = s.downscale;
  load.threads = s.threads;
  load.background = {s.background[0], s.background[1], s.background[2]};
  const auto data = load_dataset(s.data, load);
  if (!data) return std::unexpected(data.error());
  const std::vector<Photo>& photos = s.split == "train" ? data->train : data->test;
  if (photos.empty())
    return fail(s.data, "",
                fmt::format("has no {} photos; try --split {}", s.split,
                            s.split == "train" ? "test" : "train"));

  const Threads threads(s.threads);
  RenderOptions options;
  options.background = {s.background[0], s.background[1], s.background[2]};
  const auto renderer = make_renderer(s.choice, scene->cloud, options, threads);
  if (!renderer) return std::unexpected(renderer.error());
  const auto score = evaluate(photos, *renderer, threads);
  if (!score) return std::unexpected(score.error());

  if (s.as_json) {
    print_json(to_json(*score, *scene));
    return {};
  }
  for (const ViewScore& v : score->views)
    fmt::print("{:<32} {:6.2f} dB  SSIM {:.4f}\n", v.name, v.psnr, v.ssim);
  fmt::print("{:<32} {:6.2f} dB  SSIM {:.4f}  ({} splats, {} bytes)\n", "mean", score->psnr,
             score->ssim, scene->cloud.size(), scene->bytes);
  return {};
}

}  // namespace

void add_eval(CLI::App& app, Action& action) {
  auto s = std::make_shared<EvalSettings>();
  CLI::App* command = app.add_subcommand("eval", "Compare a scene with photos: PSNR and SSIM");
  command->footer("Example: fluxgs eval garden.glb --data captures/garden --downscale 2 --json");
  command->add_option("scene", s->scene, "the scene file")->required();
  command->add_option("--data", s->data, "the data set with the photos")->required();
  command->add_option("--split", s->split, "test or train")
      ->check(CLI::IsMember({"test", "train"}))
      ->capture_default_str();
  command->add_option("--downscale", s->downscale, "reduce the photos by this factor")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  add_renderer_options(*command, s->choice);
  add_background(*command, s->background);
  command->add_option("--threads", s->threads, "0: all cores")->check(CLI::Range(0, 1024));
  command->add_flag("--json", s->as_json, "print one JSON object");
  command->callback([s, &action] { action = [s] { return eval(*s); }; });
}

}  // namespace fluxgs::cli
