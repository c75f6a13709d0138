// fluxgs view: a scene in a window.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "camera/focus.h"
#include "platform/host/window.h"
#include "render/scene_view.h"
#include "tools/fluxgs/command.h"
#include "tools/fluxgs/console.h"
#include "tools/fluxgs/data_options.h"
#include "tools/fluxgs/renderers.h"
#include "tools/fluxgs/view_input.h"
#include "tools/fluxgs/view_script.h"
#include "tools/fluxgs/view_start.h"
#include "tools/fluxgs/views.h"
#include "trainer/data/image_io.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr double kIdleWait = 5, kMinimisedWait = 0.1;  // seconds
constexpr double kLongestStep = 0.1;                   // after a pause the scene must not jump
constexpr double kTitleEvery = 0.25;

struct ViewSettings {
  std::string scene, up = "auto", camera_file, screenshot, input;
  DataOptions data;
  ImageSize size{1280, 720};
  int sh_degree = 3, frames = 0;
  double memory = 0;  // MB; 0: what there is
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The state of the window and what is shown in it. Members in the order in which they depend on
/// each other.
struct Viewer {
  std::unique_ptr<host::Window> window;
  std::optional<render::SceneView> scene;
  std::shared_ptr<const SplatCloud> cloud;
  RenderOptions options;
  camera::Navigation navigation;
  ViewInput input;
  std::vector<ScriptedEvent> script;
  std::size_t next_event = 0;   // of the script
  std::string name;             // for the title
  std::size_t told_splats = 0;  // what the user was told last
  bool told_enlarged = false, told_coarse = false;
  int steps = 0, drawn = 0;
  double frame_seconds = 0;  // smoothed
  Clock::time_point titled;
};

json camera_json(const camera::ViewState& view, const glm::dvec2& size) {
  const double height = camera::units_per_pixel(view, 1, size) * size.y;
  const auto list = [](const glm::dvec3& v) { return json{v.x, v.y, v.z}; };
  return json::array({{{"name", "view"},
                       {"position", list(camera::eye(view))},
                       {"target", list(view.target)},
                       {"up", list(-camera::down(view))},
                       {"fovY", 2 * std::atan(0.5 * height) * 180 / std::numbers::pi}}});
}

glm::dvec2 as_vector(const host::WindowSize& size) { return {size.width, size.height}; }

void handle(Viewer& v, const host::WindowEvent& event, double time, bool& quit) {
  const glm::dvec2 size = as_vector(v.window->size());
  camera::Navigation& n = v.navigation;
  const ViewRequest request = apply(event, time, size, v.input, n);
  quit = quit || request.quit;
  if (request.print_camera) {
    print_json(camera_json(n.view, size));
    std::fflush(stdout);
  }
  if (!request.focus) return;
  const auto point =
      camera::visible_point(*v.cloud, n.view, *request.focus, size, n.units.near_plane);
  if (point) camera::go_to(n, camera::focused_on(n.view, *point, n.units.distances));
}

/// The script's events of this step; afterwards the window has its new size.
void play(Viewer& v, bool& quit) {
  for (; v.next_event < v.script.size() && v.script[v.next_event].step <= v.steps; ++v.next_event) {
    const ScriptedEvent& scripted = v.script[v.next_event];
    if (scripted.lose_context)
      v.window->api().lost = true;
    else if (scripted.resize.width > 0)
      v.window->resize(scripted.resize);
    else
      handle(v, scripted.event, v.steps * kScriptStep, quit);
  }
}

/// Small changes, as every new size of the window brings them, are not worth a line.
void tell_room(Viewer& v, const host::WindowSize& size) {
  const std::size_t splats = v.scene->splats(), told = v.told_splats;
  if (std::max(splats, told) - std::min(splats, told) > told / 10) {
    v.told_splats = splats;
    if (v.scene->shows_all())
      spdlog::info("all {} splats are shown", splats);
    else
      spdlog::warn(
          "warning: graphics memory is short: {} of {} splats are shown, those that add most",
          splats, v.cloud->size());
  }
  const bool enlarged = v.scene->target().width() < size.width;
  if (enlarged && !v.told_enlarged)
    spdlog::warn("warning: graphics memory is short: images of {}x{} pixels are enlarged",
                 v.scene->target().width(), v.scene->target().height());
  v.told_enlarged = enlarged;
  const bool coarse = v.scene->is_reduced() && v.scene->shows_all() && !enlarged;
  if (coarse && !v.told_coarse)
    spdlog::warn("warning: graphics memory is short: colours are blended in half floats");
  v.told_coarse = coarse;
}

render::SceneViewSettings scene_settings(const ViewSettings& s, const gl::Api& api) {
  using render::SorterKind;
  render::SceneViewSettings settings{.renderer = {.timestamps = true}};
  if (api.quirks.runs_on_cpu) settings.renderer.sorter = SorterKind::cpu_async;
  constexpr double kMegabyte = 1e6;
  if (s.memory > 0) settings.memory = static_cast<std::size_t>(s.memory * kMegabyte);
  return settings;
}

Expected<void> open_window(Viewer& v, const ViewSettings& s, const host::WindowSize& size) {
  auto window =
      host::open_window({.title = v.name, .size = size, .wait_for_display = s.frames == 0});
  if (!window) return std::unexpected(window.error());
  v.window = std::move(*window);
  spdlog::info("GL renderer: {}", v.window->renderer_string());
  v.scene.emplace(v.cloud, scene_settings(s, v.window->api()));
  auto opened = v.scene->open(v.window->api(), size.width, size.height);
  // What is drawn for a script shall be the same every time
  if (opened) v.scene->renderer().wait_for_sorts(s.frames > 0 || !v.script.empty());
  if (opened) warn_of_undrawable(v.scene->renderer());
  return opened;
}

/// The GPU was reset, or taken away: another window with everything in it made again.
Expected<void> recover(Viewer& v, const ViewSettings& s) {
  spdlog::warn("warning: the graphics context was lost; starting it again");
  const host::WindowSize size = v.window->size();
  v.scene.reset();
  v.window.reset();
  return open_window(v, s, size);
}

Expected<void> draw(Viewer& v, const host::WindowSize& size) {
  const Camera camera = camera::camera_of(v.navigation.view, size.width, size.height);
  if (auto drawn = v.scene->draw(camera, v.options); !drawn) return drawn;
  render::copy_to_window(v.window->api(), v.scene->target(), size.width, size.height);
  return {};
}

Expected<void> take_screenshot(Viewer& v, const std::string& file, const host::WindowSize& size) {
  const auto image = host::read_window(v.window->api(), size);
  if (!image) return std::unexpected(image.error());
  return write_png(file, *image);
}

void count_frame(Viewer& v, double seconds) {
  constexpr double kSmoothing = 0.1;
  v.frame_seconds = v.frame_seconds > 0 ? std::lerp(v.frame_seconds, seconds, kSmoothing) : seconds;
}

/// Waits for the GPU, and so not in every frame.
Expected<void> update_title(Viewer& v) {
  if (v.drawn > 1 && seconds_since(v.titled) < kTitleEvery) return {};
  v.titled = Clock::now();
  const auto stats = v.scene->renderer().stats();
  if (!stats && gl::context_lost(v.window->api())) return {};  // The next frame sees to it
  if (!stats) return std::unexpected(stats.error());
  std::string title =
      fmt::format("{} - {:.0f} frames/s - {} of {} splats", v.name,
                  1 / std::max(v.frame_seconds, 1e-6), stats->drawn, v.cloud->size());
  if (const auto& stages = stats->stages)
    title += fmt::format(" - sort {:.1f} ms, draw {:.1f} ms", stages->sort,
                         stages->project + stages->draw + stages->resolve);
  v.window->set_title(title);
  return {};
}

/// Draws, takes the screenshot if this is the last frame, and shows.
Expected<void> show(Viewer& v, const ViewSettings& s, const host::WindowSize& size, bool last) {
  const Clock::time_point start = Clock::now();
  const auto image = [&]() -> Expected<void> {
    if (auto drawn = draw(v, size); !drawn || !last || s.screenshot.empty()) return drawn;
    return take_screenshot(v, s.screenshot, size);
  };
  auto done = image();
  if (!done && gl::context_lost(v.window->api())) {
    done = recover(v, s);
    if (done) done = image();
  }
  if (!done) return done;
  ++v.drawn;
  tell_room(v, size);
  v.window->present();
  count_frame(v, seconds_since(start));
  return update_title(v);
}

bool same(const camera::ViewState& a, const camera::ViewState& b) {
  return a.target == b.target && a.orientation == b.orientation && a.distance == b.distance &&
         a.fov == b.fov;
}

/// The events of people, or of the script while it lasts. Returns whether the window must be drawn.
bool take_events(Viewer& v, double wait, double time, bool& quit) {
  const camera::ViewState before = v.navigation.view;
  const bool scripted = v.next_event < v.script.size();
  bool uncovered = false;
  for (const host::WindowEvent& event : v.window->events(wait)) {
    uncovered = uncovered || event.kind == host::WindowEvent::Kind::uncovered;
    if (!scripted) handle(v, event, time, quit);
  }
  if (scripted) play(v, quit);
  return uncovered || !same(before, v.navigation.view);
}

bool is_empty(const host::WindowSize& size) { return size.width < 1 || size.height < 1; }

/// How long nothing needs to be done if nobody does anything.
double time_to_wait(const Viewer& v, bool stepping, bool idle) {
  if (stepping) return 0;
  if (is_empty(v.window->size())) return kMinimisedWait;
  return idle ? kIdleWait : 0;
}

/// Until it is closed. Draws only what has changed, and sleeps otherwise.
Expected<void> run(Viewer& v, const ViewSettings& s) {
  const Clock::time_point start = Clock::now();
  double before = 0;
  bool redraw = true, quit = false, last = false;
  host::WindowSize shown;
  for (; !quit && !last && !v.window->close_requested(); ++v.steps) {
    // Time goes by steps, not by the clock, where what is drawn shall be the same every time
    const bool stepping = s.frames > 0 || v.next_event < v.script.size();
    const bool idle = !redraw && !camera::moving(v.navigation);
    const double wait = time_to_wait(v, stepping, idle);
    redraw = take_events(v, wait, seconds_since(start), quit) || redraw || s.frames > 0;
    const double now = seconds_since(start);
    const double passed = idle ? 0 : std::min(now - before, kLongestStep);
    before = now;
    const host::WindowSize size = v.window->size();
    const bool moved =
        camera::advance(v.navigation, stepping ? kScriptStep : passed, as_vector(size));
    redraw = redraw || moved || size != shown;
    last = s.frames > 0 && v.steps + 1 >= s.frames;
    if (!redraw || is_empty(size)) continue;
    if (auto done = show(v, s, size, last); !done) return done;
    shown = size;
    redraw = !v.scene->renderer().order_is_current();
  }
  return {};
}

Expected<void> load_into(Viewer& v, const ViewSettings& s) {
  auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  const auto data = load_if_given(s.data);
  if (!data) return std::unexpected(data.error());
  std::optional<Camera> camera;
  if (!s.camera_file.empty()) {
    const auto cameras = cameras_from_file(s.camera_file, s.size);
    if (!cameras) return std::unexpected(cameras.error());
    camera = cameras->front();
  }
  const auto up = parse_up(s.up);
  if (!up) return std::unexpected(up.error());
  ViewStart start = choose_start(*scene, *data, camera, *up, s.size);
  v.navigation = start.navigation;
  const glm::dvec3& axis = v.navigation.up;
  spdlog::info("up: {:.2f},{:.2f},{:.2f} ({}; F flips it)", axis.x, axis.y, axis.z,
               start.up_source);
  v.cloud = std::make_shared<const SplatCloud>(std::move(scene->cloud));
  v.told_splats = v.cloud->size();
  v.name = std::filesystem::path(s.scene).filename().string();
  v.options.background = s.data.background_color();
  v.options.sh_degree = s.sh_degree;
  v.options.near_plane = v.navigation.units.near_plane;
  return {};
}

Expected<void> view(const ViewSettings& s) {
  if (!s.screenshot.empty() && std::filesystem::path(s.screenshot).extension() != ".png")
    return fail(s.screenshot, "", "images are written as PNG, expected a name that ends in .png");
  Viewer v;
  if (!s.input.empty()) {
    auto script = read_view_script(s.input);
    if (!script) return std::unexpected(script.error());
    v.script = std::move(*script);
  }
  if (auto loaded = load_into(v, s); !loaded) return loaded;
  if (auto opened = open_window(v, s, {s.size.width, s.size.height}); !opened) return opened;
  if (s.frames == 0) say(kViewKeys);
  auto done = run(v, s);
  if (done) spdlog::info("{} frames drawn in {} steps", v.drawn, v.steps);
  return done;
}

}  // namespace

void add_view(CLI::App& app, Action& action) {
  auto s = std::make_shared<ViewSettings>();
  CLI::App* command = app.add_subcommand("view", "A scene in a window");
  command->footer(std::string(kViewKeys) +
                  "Example: fluxgs view garden.glb --data captures/garden\n"
                  "Example: fluxgs view garden.glb --frames 1 --screenshot window.png");
  command->add_option("scene", s->scene, "the scene file")->required();
  CLI::Option* data = command->add_option("--data", s->data.folder,
                                          "a data set: start at its first image, up as there");
  command
      ->add_option("--camera", s->camera_file,
                   "start at the first of a JSON list of {name, position, target, up, fovY}")
      ->excludes(data);
  command->add_option("--up", s->up, "x,y,z, or auto: from the images of --data or from the splats")
      ->check(CLI::Validator(
          [](const std::string& text) {
            const auto up = parse_up(text);
            return up ? std::string() : up.error().message();
          },
          "x,y,z|auto"))
      ->capture_default_str();
  add_size_option(*command, s->size, "WIDTHxHEIGHT of the window (default: 1280x720)");
  command->add_option("--sh-degree", s->sh_degree, "evaluate no more than this degree")
      ->check(CLI::Range(0, 3));
  command
      ->add_option("--memory", s->memory,
                   "MB of graphics memory that may be used; the splats that add least are left out")
      ->check(in_range(0.001, 1e6));
  add_data_options(*command, s->data);
  CLI::Option* frames =
      command->add_option("--frames", s->frames, "draw this many frames of 1/60 s, then close")
          ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option("--screenshot", s->screenshot,
                   "a PNG of what is in the window in the last frame")
      ->needs(frames);
  command->add_option("--input", s->input,
                      "a JSON list of what the mouse and the keys do (tests, reports of mistakes)");
  command->callback([s, &action] { action = [s] { return view(*s); }; });
}

}  // namespace fluxgs::cli
