// fluxgs bench: how long frames take, off the screen.
#include "bench/frame_benchmark.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "gl/expected_chain.h"
#include "platform/host/host_context.h"
#include "tools/fluxgs/cameras/cameras.h"
#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/options/tuning_options.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/peak_memory.h"
#include "tools/fluxgs/terminal/progress.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct BenchSettings {
  std::string scene, camera_file, gl = "egl";
  DataOptions data;
  ImageSize size{1280, 720};
  TuningOptions tuning;
  bench::FrameBenchmarkOptions protocol{.warmup = 10, .frames = 100};
  double orbit_step = 0;  // degrees
  bool as_json = false;
};

/// Cameras from the file, those of the data set, or eight around the scene.
Expected<std::vector<Camera>> still_views(const BenchSettings& s, const SplatCloud& cloud) {
  if (!s.camera_file.empty()) return cameras_from_file(s.camera_file, s.size);
  constexpr int kViews = 8;
  if (s.data.folder.empty()) return orbit_around(cloud, kViews, s.size);
  const auto data = load(s.data);
  if (!data) return std::unexpected(data.error());
  return orbit_along(data->train, kViews, s.size);
}

/// The camera turned by `angle`, in radians, about the vertical of its own image through the
/// point that it looks at, which is where the middle of the scene is nearest to its axis.
Camera turned(const Camera& camera, double angle, const glm::dvec3& middle) {
  const glm::dvec3 centre = camera.center(), forward = camera.forward();
  const glm::dvec3 target = centre + forward * std::max(glm::dot(middle - centre, forward), 1e-6);
  const glm::dvec3 up(camera.rotation[0][1], camera.rotation[1][1], camera.rotation[2][1]);
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1.0), angle, up));
  Camera moved = camera;
  moved.rotation = camera.rotation * glm::transpose(turn);
  moved.translation = -(moved.rotation * (target + turn * (centre - target)));
  return moved;
}

glm::dvec3 middle_of(const SplatCloud& cloud) {
  glm::dvec3 sum(0.0);
  for (const glm::vec3& p : cloud.positions) sum += glm::dvec3(p);
  return sum / static_cast<double>(std::max<std::size_t>(cloud.size(), 1));
}

/// Still views, or with --orbit-step a path from the first of them.
Expected<std::vector<Camera>> views_of(const BenchSettings& s, const SplatCloud& cloud) {
  auto views = still_views(s, cloud);
  if (!views || s.orbit_step == 0) return views;
  const glm::dvec3 middle = middle_of(cloud);
  std::vector<Camera> path;
  for (int i = 0; i < s.protocol.frames; ++i)
    path.push_back(turned(views->front(), i * s.orbit_step * std::numbers::pi / 180, middle));
  return path;
}

json summary_json(const bench::Summary& summary) {
  return {{"median", summary.median},
          {"p95", summary.p95},
          {"mean", summary.mean},
          {"least", summary.least}};
}

json stages_json(const bench::FrameBenchmark& result) {
  if (!result.stages) return nullptr;
  const render::FrameTimes& s = *result.stages;
  return {{"project", s.project}, {"sort", s.sort}, {"draw", s.draw}, {"resolve", s.resolve}};
}

json traffic_json(const bench::FrameTraffic& t) {
  return {{"project", t.project},
          {"sort", t.sort},
          {"vertices", t.vertices},
          {"blend_tiled", t.blend_tiled},
          {"blend_immediate", t.blend_immediate},
          {"resolve", t.resolve}};
}

void print_bench(const json& r) {
  const auto line = [&](const char* label, const json& ms) {
    fmt::print("{:<15} median {:.2f} ms, mean {:.2f}, 95% within {:.2f}  ({:.1f} frames/s)\n",
               label, ms["median"].get<double>(), ms["mean"].get<double>(), ms["p95"].get<double>(),
               1000 / ms["mean"].get<double>());
  };
  fmt::print(
      "{}\n{} splats of degree {}, {} drawn in the initial view; {}\n",
      r["gl_renderer"].get<std::string>(), r["splats"].get<std::size_t>(),
      r["sh_degree"].get<int>(), r["splats_drawn"].get<std::uint64_t>(),
      r["target"].get<std::string>() +
          (r["slices"] > 1 ? fmt::format(", front to back in {} slices", r["slices"].dump()) : ""));
  line("draw only", r["in_flight_ms"]);
  line("waited for", r["draw_ms"]);
  line("sort to display", r["sort_to_display_ms"]);
  fmt::print("{:<15} {:.2f} ms a frame\n", "pipelined", r["pipelined_ms"].get<double>());
  if (!r["stages"].is_null()) {
    fmt::print("{:<15}", "stages");
    for (const char* name : {"project", "sort", "draw", "resolve"})
      fmt::print(" {} {:.2f} ms", name, r["stages"][name].get<double>());
    fmt::print("\n");
  }
  fmt::print("{:<15} {:.1f} MB on a GPU with tiles, {:.1f} MB on one without (a model)\n",
             "moved a frame", 1e-6 * r["bytes_per_frame"].get<double>(),
             1e-6 * r["bytes_per_frame_immediate"].get<double>());
  fmt::print("{:<15} {:.1f} MB of the GPU (estimate), {:.0f} MB of the process at most\n", "memory",
             1e-6 * r["gpu_memory_bytes"].get<double>(),
             1e-6 * r["peak_memory_bytes"].get<double>());
}

/// GL objects of a measurement. Members in the order in which they depend on each other.
struct Stage {
  std::unique_ptr<host::HostContext> context;
  std::unique_ptr<render::Renderer> renderer;
  render::RenderTarget target;
};

Expected<Stage> set_up(const BenchSettings& s, const render::RenderCloud& cloud) {
  const auto implementation = host::parse_host_gl(s.gl);
  if (!implementation) return std::unexpected(implementation.error());
  Stage stage;
  auto done = gl::chain(
      [&] {
        return gl::assign_or_error(host::HostContext::create(*implementation), stage.context);
      },
      [&] {
        return gl::assign_or_error(
            render::Renderer::create(stage.context->api(), settings_of(s.tuning)), stage.renderer);
      },
      [&] { return stage.renderer->upload(cloud); },
      [&] {
        return gl::assign_or_error(
            target_of(stage.context->api(), s.size.width, s.size.height, s.tuning), stage.target);
      });
  if (!done) return std::unexpected(done.error());
  warn_of_undrawable(*stage.renderer);
  warn_of_slices(*stage.renderer, s.tuning);
  return stage;
}

/// Counts of the view, which is drawn again so that what is read back belongs to it.
Expected<bench::FrameCounts> counts_of(const Stage& stage, const render::RenderCloud& cloud,
                                       const Camera& view, const RenderOptions& options) {
  if (auto drawn = stage.renderer->draw(view, options, stage.target); !drawn)
    return std::unexpected(drawn.error());
  return bench::count_frame(*stage.renderer, cloud, view, options, stage.target);
}

Expected<void> bench_scene(const BenchSettings& s) {
  std::optional<Expected<SceneFile>> scene;
  const double load_ms = bench::milliseconds_of([&] { scene = load_scene(s.scene); });
  if (!*scene) return std::unexpected(scene->error());
  const auto views = views_of(s, (*scene)->cloud);
  if (!views) return std::unexpected(views.error());
  render::RenderCloud cloud(std::move((*scene)->cloud));
  const double order_ms = bench::milliseconds_of([&] { put_in_order(cloud); });
  const auto stage = set_up(s, cloud);
  if (!stage) return std::unexpected(stage.error());

  RenderOptions options = tuned({}, s.tuning);
  options.background = s.data.background_color();
  const ProgressReport bar = show_progress("frames");
  const auto result =
      bench::benchmark_frames(stage->context->api(), *stage->renderer, stage->target, *views,
                              options, s.protocol, [&](int done, int all) {
                                bar(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
                                return true;
                              });
  if (!result) return std::unexpected(result.error());
  const auto counts = counts_of(*stage, cloud, views->front(), options);
  if (!counts) return std::unexpected(counts.error());
  const bench::FrameTraffic traffic =
      bench::model_traffic(*counts, stage->renderer->settings(), plan_of(stage->target));
  const render::MemoryEstimate memory = render::estimate_memory(
      count_degrees(cloud), stage->renderer->settings(), plan_of(stage->target));

  const json report = {{"gl_renderer", stage->context->renderer_string()},
                       {"size", {s.size.width, s.size.height}},
                       {"target", name_of(stage->target)},
                       {"frames", s.protocol.frames},
                       {"views", views->size()},
                       {"splats", cloud.size()},
                       {"sh_degree", std::min(cloud.sh_degree, s.tuning.sh_degree)},
                       {"sorter", s.tuning.sorter},
                       {"slices", stage->renderer->settings().slices},
                       {"in_flight_ms", summary_json(result->in_flight_ms)},
                       {"draw_ms", summary_json(result->draw_ms)},
                       {"sort_to_display_ms", summary_json(result->sort_to_display_ms)},
                       {"pipelined_ms", result->pipelined_ms},
                       {"stages", stages_json(*result)},
                       {"splats_drawn", counts->drawn},
                       {"fragments", counts->fragments},
                       {"bytes_per_frame", traffic.tiled()},
                       {"bytes_per_frame_immediate", traffic.immediate()},
                       {"traffic", traffic_json(traffic)},
                       {"load_ms", load_ms},
                       {"order_ms", order_ms},
                       {"gpu_memory_bytes", memory.total()},
                       {"peak_memory_bytes", peak_memory()}};
  if (s.as_json)
    print_json(report);
  else
    print_bench(report);
  return {};
}

}  // namespace

void add_bench(CLI::App& app, Action& action) {
  auto s = std::make_shared<BenchSettings>();
  CLI::App* command = app.add_subcommand("bench", "Time frames of a scene without a window");
  command->footer(
      "Four times, after a warm-up. \"draw only\": a frame whose splats are already sorted, while "
      "the\n"
      "next one is prepared, as in an app. \"waited for\": such a frame by itself, from the call "
      "to\n"
      "its end. \"sort to display\": the same with the sort for a new view. \"pipelined\": the "
      "mean\n"
      "of frames without any wait. Views: those of --camera, eight along the images of --data, or\n"
      "eight around the scene.\n"
      "Example: fluxgs bench garden.glb --size 1280x720 --frames 200\n"
      "Example: fluxgs bench garden.glb --orbit-step 0.5 --sorter cpu --json");
  command->add_option("scene", s->scene, "the scene file")->required();
  add_size_option(*command, s->size, "WIDTHxHEIGHT (default: 1280x720)");
  command->add_option("--frames", s->protocol.frames, "timed frames of each kind")
      ->check(whole_in(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--warmup", s->protocol.warmup, "frames before the timing")
      ->check(whole_in(0, 1'000'000))
      ->capture_default_str();
  CLI::Option* data =
      command->add_option("--data", s->data.folder, "a data set: views along its images");
  command
      ->add_option("--camera", s->camera_file,
                   "JSON list of {name, position, target, up, fovY in degrees}")
      ->excludes(data);
  command
      ->add_option("--orbit-step", s->orbit_step,
                   "turn the first camera by this angle in each frame, degrees")
      ->check(in_range(-180.0, 180.0));
  command->add_option("--gl", s->gl, "egl, osmesa or angle")
      ->check(CLI::IsMember(kGlNames))
      ->capture_default_str();
  add_data_options(*command, s->data);
  add_tuning_options(*command, s->tuning);
  command->add_flag("--json", s->as_json, "print one JSON object");
  command->callback([s, &action] { action = [s] { return bench_scene(*s); }; });
}

}  // namespace fluxgs::cli
