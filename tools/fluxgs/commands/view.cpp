// fluxgs view: a scene in a window.
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/gltf.h"
#include "platform/host/window_screen.h"
#include "tools/fluxgs/cameras/cameras.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/cameras/path_file.h"
#include "tools/fluxgs/cameras/view_script.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "trainer/data/image_io.h"
#include "viewer/presenter.h"
#include "viewer/scene_loading.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;
using viewer::WindowEvent;
using Clock = std::chrono::steady_clock;

constexpr double kIdleWait = 5, kFollowWait = 0.5, kFrame = 1.0 / 60;  // seconds
constexpr double kTitleEvery = 0.25;
constexpr auto kLoadWait = std::chrono::milliseconds(2);

/// For --help and the start.
const std::string kKeys = std::string(viewer::kMouseAndKeysHelp) +
                          "  P            print the camera, as --camera takes it\n"
                          "  Escape       close\n";

struct ViewSettings {
  std::string scene, up = "auto", camera_file, path_file, screenshot, input;
  DataOptions data;
  ImageSize size{1280, 720};
  std::string renderer = kAnyRenderer;
  int sh_degree = 3, frames = 0;
  bool follow = false;
  double memory = 0;  // MB; 0: what there is
};

/// Notices about graphics memory that were shown.
struct MemoryNotices {
  std::size_t splats = 0;
  bool enlarged = false, coarse = false;
};

/// The window, what is shown in it, and what happens there.
struct Desktop {
  viewer::Presenter presenter;
  host::WindowScreen& window;  // the presenter's screen
  std::string name;            // for the title
  std::vector<ScriptedEvent> script;
  std::size_t next_event = 0;  // of the script
  MemoryNotices told;
  int steps = 0, drawn = 0, contexts = 0;
  bool quit = false;
  Clock::time_point titled = {};
  viewer::SceneLoading* loading = nullptr;  // of what is shown
};

/// Notices when a file is replaced by another, or written again.
class FollowedFile {
 public:
  explicit FollowedFile(std::string path) : path_(std::move(path)), last_(stamp()) {}

  const std::string& path() const { return path_; }
  /// True once for each new content.
  bool changed() {
    const auto now = stamp();
    return now && std::exchange(last_, now) != now;
  }

 private:
  /// Not the time alone: files that are written within a tick of the clock have the same.
  struct Stamp {
    ino_t file = 0;
    off_t bytes = 0;
    time_t seconds = 0;
    long nanoseconds = 0;
    bool operator==(const Stamp&) const = default;
  };
  std::optional<Stamp> stamp() const {
    struct stat status{};
    if (::stat(path_.c_str(), &status) != 0) return std::nullopt;
    return Stamp{status.st_ino, status.st_size, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
  }

  std::string path_;
  std::optional<Stamp> last_;
};

/// The scene, and where it is looked at from.
struct Scene {
  std::shared_ptr<const render::RenderCloud> cloud;
  camera::Navigation navigation;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

json camera_json(const camera::ViewState& view, const host::WindowSize& window) {
  const glm::dvec2 size(window.width, window.height);
  const double height = camera::units_per_pixel(view, 1, size) * size.y;
  const auto list = [](const glm::dvec3& v) { return json{v.x, v.y, v.z}; };
  return json::array({{{"name", "view"},
                       {"position", list(camera::eye(view))},
                       {"target", list(view.target)},
                       {"up", list(-camera::down(view))},
                       {"fovY", 2 * std::atan(0.5 * height) * 180 / std::numbers::pi}}});
}

void fit_window(Desktop& d) {
  const host::WindowSize size = d.window.size();
  d.presenter.resize(size.width, size.height);
}

void handle(Desktop& d, const WindowEvent& event, double seconds) {
  using Kind = WindowEvent::Kind;
  if (event.kind == Kind::key && event.key == viewer::kEscape && event.down) d.quit = true;
  if (event.kind == Kind::text && (event.key == 'p' || event.key == 'P')) {
    print_json(camera_json(d.presenter.viewer().navigation().view, d.window.size()));
    std::fflush(stdout);
  }
  fit_window(d);
  d.presenter.viewer().handle(event, seconds);
}

/// The script's events of this step; afterwards the window has its new size.
void play(Desktop& d) {
  for (; d.next_event < d.script.size() && d.script[d.next_event].step <= d.steps; ++d.next_event) {
    const ScriptedEvent& scripted = d.script[d.next_event];
    if (scripted.lose_context)
      d.presenter.lose_context();
    else if (scripted.resize.width > 0)
      d.window.resize(scripted.resize);
    else
      handle(d, scripted.event, d.steps * kScriptStep);
  }
}

/// The events of people, or of the script while it lasts.
void take_events(Desktop& d, double wait, Clock::time_point start) {
  const bool scripted = d.next_event < d.script.size();
  for (const WindowEvent& event : d.window.events(wait)) {
    if (event.kind == WindowEvent::Kind::uncovered) d.presenter.redraw();
    if (!scripted) handle(d, event, seconds_since(start));
  }
  if (scripted) play(d);
}

/// Small changes, as every new size of the window brings them, are not worth a line.
void tell_memory(MemoryNotices& told, const render::SceneView& scene, std::size_t all,
                 const host::WindowSize& size) {
  const std::size_t splats = scene.splats();
  if (std::max(splats, told.splats) - std::min(splats, told.splats) > told.splats / 10) {
    told.splats = splats;
    if (scene.shows_all())
      spdlog::info("all {} splats are shown", splats);
    else
      spdlog::warn(
          "warning: graphics memory is short: {} of {} splats are shown, those that add most",
          splats, all);
  }
  const render::ImageSize image = scene.image_size();
  const bool enlarged = image.width < size.width;
  if (!std::exchange(told.enlarged, enlarged) && enlarged)
    spdlog::warn("warning: graphics memory is short: images of {}x{} pixels are enlarged",
                 image.width, image.height);
  const bool coarse = scene.is_reduced() && scene.shows_all() && !enlarged;
  if (!std::exchange(told.coarse, coarse) && coarse)
    spdlog::warn("warning: graphics memory is short: colours are blended in half floats");
}

void tell_title(Desktop& d) {
  if (seconds_since(d.titled) < kTitleEvery) return;
  d.titled = Clock::now();
  const viewer::ViewerStats stats = d.presenter.viewer().stats();
  std::string title = d.name;
  if (stats.frames_per_second > 0)
    title += fmt::format(" - {:.0f} frames/s", stats.frames_per_second);
  title += fmt::format(" - {} of {} splats", stats.drawn, stats.splats);
  if (stats.draw_ms > 0)
    title += fmt::format(" - sort {:.1f} ms, draw {:.1f} ms", stats.sort_ms, stats.draw_ms);
  d.window.set_title(title);
}

/// After an image was shown.
void tell_news(Desktop& d) {
  render::SceneView& scene = d.presenter.viewer().scene();
  const bool lost = d.contexts != d.presenter.contexts();
  if (lost)
    spdlog::warn("warning: the graphics context was lost; it was made again ({})",
                 d.window.api()->capabilities.renderer);
  if (lost || d.drawn == 1) warn_of_undrawable(scene.renderer().undrawable(), scene.splats());
  d.contexts = d.presenter.contexts();
  tell_memory(d.told, scene, d.presenter.viewer().stats().splats, d.window.size());
}

std::shared_ptr<const render::RenderCloud> cloud_of(SplatCloud&& cloud) {
  return std::make_shared<const render::RenderCloud>(render::cloud_to_draw(std::move(cloud)));
}

/// A file whose scene is shown as it comes; not where every run shall draw the same frames.
std::optional<int> open_chunks(const ViewSettings& s) {
  std::error_code ignored;
  if (s.frames > 0 || !s.input.empty() || !std::filesystem::is_regular_file(s.scene, ignored))
    return std::nullopt;
  const int descriptor = ::open(s.scene.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  const FileBytes file(descriptor, 0, std::filesystem::file_size(s.scene, ignored), s.scene);
  if (const auto chunks = find_chunks(file, s.scene); chunks && !chunks->empty()) return descriptor;
  ::close(descriptor);
  return std::nullopt;
}

/// Begins to load the scene, and waits for as much of it as can be shown.
Expected<viewer::LoadedScene> first_part(int descriptor, const std::string& path,
                                         viewer::SceneLoading& loading) {
  loading.begin(descriptor, path,
                {.memory = std::numeric_limits<std::uint64_t>::max() / 4,
                 .patience = std::numeric_limits<double>::infinity()});
  for (;;) {
    if (auto scene = loading.take()) return std::move(*scene);
    const viewer::LoadState state = loading.state();
    if (state.phase == viewer::LoadPhase::failed) return fail("", "", state.error);
    std::this_thread::sleep_for(kLoadWait);
  }
}

/// Shows what has come since.
void refine(Desktop& d) {
  if (d.loading->is_over()) return;
  if (auto scene = d.loading->take()) {
    d.told.splats = scene->cloud.size();
    d.presenter.refine(std::make_shared<const render::RenderCloud>(std::move(scene->cloud)));
  }
  const viewer::LoadState state = d.loading->state();
  if (state.phase == viewer::LoadPhase::failed) spdlog::warn("warning: {}", state.error);
}

/// --follow: shows the file's new content from where the old one was looked at.
void follow(Desktop& d, FollowedFile& file) {
  if (!file.changed()) return;
  auto scene = read_scene_or_checkpoint(file.path());
  if (!scene) return spdlog::warn("warning: {}", scene.error().message());
  d.loading->cancel();
  const camera::Navigation navigation = d.presenter.viewer().navigation();
  d.presenter.show(cloud_of(std::move(scene->cloud)), navigation);
}

/// Until it is closed. Draws only what has changed, and sleeps otherwise.
Expected<void> run(Desktop& d, const ViewSettings& s, FollowedFile& file) {
  const Clock::time_point start = Clock::now();
  double before = 0;
  bool drew = false;
  for (; !d.quit && !d.window.close_requested(); ++d.steps) {
    // Time goes by steps, not by the clock, where what is drawn shall be the same every time
    const bool stepping = s.frames > 0 || d.next_event < d.script.size();
    const bool idle = d.presenter.at_rest();
    const double longest = !d.loading->is_over() ? kFrame : s.follow ? kFollowWait : kIdleWait;
    const double wait = stepping || drew ? 0 : idle ? longest : kFrame;
    take_events(d, d.steps == 0 ? 0 : wait, start);
    if (s.follow) follow(d, file);
    refine(d);
    const double now = seconds_since(start);
    const double passed = stepping ? kScriptStep : idle ? 0 : now - before;
    before = now;
    fit_window(d);
    if (s.frames > 0) d.presenter.redraw();
    const bool last = s.frames > 0 && d.steps + 1 >= s.frames;
    if (last) d.window.capture_next();
    const auto shown = d.presenter.frame(passed);
    if (!shown) return std::unexpected(shown.error());
    drew = *shown;
    if (drew) ++d.drawn, tell_news(d);
    tell_title(d);
    d.quit = d.quit || last;
  }
  return {};
}

/// What there is of the scene; more may follow from `loading`.
Expected<viewer::LoadedScene> load_what_is_there(const ViewSettings& s,
                                                 viewer::SceneLoading& loading) {
  if (const auto chunks = open_chunks(s)) return first_part(*chunks, s.scene, loading);
  auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  return viewer::LoadedScene{.cloud = render::cloud_to_draw(std::move(scene->cloud)),
                             .start = scene->start};
}

Expected<Scene> load(const ViewSettings& s, viewer::SceneLoading& loading) {
  auto scene = load_what_is_there(s, loading);
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
  const InitialNavigation initial =
      initial_navigation(scene->cloud.base, scene->start, *data, camera, *up, s.size);
  const glm::dvec3& axis = initial.navigation.up;
  spdlog::info("up: {:.2f},{:.2f},{:.2f} ({}; F flips it)", axis.x, axis.y, axis.z,
               initial.up_source);
  return Scene{std::make_shared<const render::RenderCloud>(std::move(scene->cloud)),
               initial.navigation};
}

viewer::ViewerSettings viewer_settings(const ViewSettings& s) {
  viewer::ViewerSettings settings{.scale = 1,
                                  .sh_degree = s.sh_degree,
                                  .background = s.data.background_color(),
                                  .wait_for_sorts = s.frames > 0 || !s.input.empty()};
  constexpr double kMegabyte = 1e6;
  if (s.memory > 0) settings.memory = static_cast<std::size_t>(s.memory * kMegabyte);
  return settings;
}

Expected<void> view(const ViewSettings& s) {
  if (!s.screenshot.empty() && std::filesystem::path(s.screenshot).extension() != ".png")
    return fail(s.screenshot, "", "images are written as PNG, expected a name that ends in .png");
  std::vector<ScriptedEvent> script;
  if (!s.input.empty()) {
    auto read = read_view_script(s.input);
    if (!read) return std::unexpected(read.error());
    script = std::move(*read);
  }
  FollowedFile file(s.scene);  // before it is read: what is written later is a change
  std::shared_ptr<const camera::CameraPath> path;
  if (!s.path_file.empty()) {
    const auto read = path_from_file(s.path_file);
    if (!read) return std::unexpected(read.error());
    path = std::make_shared<const camera::CameraPath>(*read);
  }
  viewer::SceneLoading loading;
  const auto scene = load(s, loading);
  if (!scene) return std::unexpected(scene.error());
  const std::string name = std::filesystem::path(s.scene).filename().string();
  auto screen = host::open_window(
      {.title = name, .size = {s.size.width, s.size.height}, .wait_for_display = s.frames == 0});
  if (!screen) return std::unexpected(screen.error());
  host::WindowScreen& window = **screen;
  spdlog::info("GL renderer: {}", window.api()->capabilities.renderer);
  Desktop d{.presenter = viewer::Presenter(std::move(*screen)),
            .window = window,
            .name = name,
            .script = std::move(script),
            .told = {.splats = scene->cloud->size()},
            .loading = &loading};
  d.presenter.viewer().set(viewer_settings(s));
  const Threads threads(s.data.threads);
  const bool on_cpu = s.renderer == "cpu" || (s.renderer == kAnyRenderer && s.memory == 0 &&
                                              window.api()->quirks.runs_on_cpu);
  if (on_cpu) {
    spdlog::info("drawn by the processor; --renderer gles: by OpenGL");
    d.presenter.viewer().draw_in_software(
        [&threads](const std::shared_ptr<const render::RenderCloud>& cloud) {
          return software_renderer(splat_cloud_of(*cloud), threads);
        });
  }
  d.presenter.show(scene->cloud, scene->navigation);
  fit_window(d);
  if (path) d.presenter.viewer().play(path);
  if (s.frames == 0 && !s.follow) say(kKeys);
  if (auto done = run(d, s, file); !done) return done;
  spdlog::info("{} frames drawn in {} steps", d.drawn, d.steps);
  const auto last = window.take_captured();
  return last && !s.screenshot.empty() ? write_png(s.screenshot, *last) : Expected<void>();
}

}  // namespace

void add_view(CLI::App& app, Action& action) {
  auto s = std::make_shared<ViewSettings>();
  CLI::App* command = app.add_subcommand("view", "Show a scene in a window");
  command->footer(kKeys +
                  "Without a display, fluxgs render and fluxgs turntable write images and videos.\n"
                  "Example: fluxgs view garden.glb --data captures/garden\n"
                  "Example: fluxgs view garden.glb --frames 1 --screenshot window.png");
  command->add_option("scene", s->scene, "the scene file")->required();
  CLI::Option* data = command->add_option("--data", s->data.folder,
                                          "a data set: start at its first image, up as there");
  command
      ->add_option(
          "--camera", s->camera_file,
          "start at the first of a JSON list of {name, position, target, up, fovY in degrees}")
      ->excludes(data);
  command->add_option("--path", s->path_file,
                      "play a camera path until a mouse button is pressed: SuperSplat's\n"
                      "settings.json, or a list as of --camera");
  command->add_option("--up", s->up, "x,y,z, or auto: from the images of --data or from the splats")
      ->check(CLI::Validator(
          [](const std::string& text) {
            const auto up = parse_up(text);
            return up ? std::string() : up.error().message();
          },
          "x,y,z|auto"))
      ->capture_default_str();
  add_size_option(*command, s->size, "WIDTHxHEIGHT of the window (default: 1280x720)");
  command->add_option("--sh-degree", s->sh_degree, "highest SH degree to evaluate")
      ->check(whole_in(0, 3));
  command
      ->add_option(
          "--renderer", s->renderer,
          "gles (the phone's), cpu (the trainer's), or auto: gles on a graphics card, else "
          "cpu")
      ->check(CLI::IsMember({kAnyRenderer, "gles", "cpu"}))
      ->capture_default_str();
  command
      ->add_option("--memory", s->memory,
                   "limit of graphics memory, MB; splats of least contribution are left out")
      ->check(in_range(0.001, 1e6));
  add_data_options(*command, s->data);
  CLI::Option* frames =
      command->add_option("--frames", s->frames, "show this many frames, 1/60 s each, then close")
          ->check(whole_in(1, 1'000'000));
  command->add_option("--screenshot", s->screenshot, "write the last frame as a PNG")
      ->needs(frames);
  command->add_flag("--follow", s->follow, "show the file anew whenever it is written again");
  command->add_option("--input", s->input,
                      "play mouse and keys from a JSON list (for tests and bug reports)");
  command->callback([s, &action] { action = [s] { return view(*s); }; });
}

}  // namespace fluxgs::cli
