// fluxgs web: a scene as a page for browsers.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "camera/navigation.h"
#include "fluxgs/io/file.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/web_page.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/files.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "trainer/core/planar_image.h"
#include "trainer/data/image_io.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

struct WebSettings {
  std::string scene, out, title, address;
  std::vector<double> background{0, 0, 0};
  RendererChoice choice;
  bool turntable = false, no_poster = false, force = false, as_json = false;
};

struct Written {
  std::string file;
  std::size_t bytes = 0;
};

Expected<std::string> text_of(const fs::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

/// "#rrggbb" of a colour from 0 to 1.
std::string hex(const glm::dvec3& colour) {
  const auto byte = [](double value) {
    return static_cast<int>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour.x), byte(colour.y), byte(colour.z));
}

/// The scene's start view as a JPEG.
Expected<std::vector<std::byte>> poster_of(const WebSettings& s, const SceneFile& scene,
                                           const glm::dvec3& background) {
  constexpr ImageSize kSize{1200, 675};  // what chats show of a link
  constexpr int kQuality = 82;
  const Threads threads(0);
  RenderOptions options;
  options.background = background;
  RendererChoice choice = s.choice;
  choice.renderer = renderer_for(s.choice);
  const auto render = make_renderer(choice, scene.cloud, options, threads);
  if (!render) return std::unexpected(render.error());
  const camera::Navigation first =
      initial_navigation(scene.cloud, scene.start, std::nullopt, std::nullopt, std::nullopt, kSize)
          .navigation;
  const auto image = (*render)(camera::camera_of(first.view, kSize.width, kSize.height));
  if (!image) return std::unexpected(image.error());
  return encode_jpeg("poster", interleaved(*image), kQuality);
}

/// One file; a page that is there already stays without --force.
Expected<std::vector<Written>> write_page(const WebSettings& s, const std::string& viewer,
                                          WebPage shown, std::span<const std::byte> scene,
                                          std::span<const std::byte> poster) {
  if (!poster.empty()) shown.poster = "data:image/jpeg;base64," + base64(poster);
  const std::string file = (fs::path(viewer) / "page.html").string();
  const auto empty = text_of(file);
  if (!empty) return std::unexpected(empty.error());
  const auto page = page_with(file, *empty, shown, scene);
  if (!page) return std::unexpected(page.error());
  if (auto done = write_file_atomic(s.out, bytes_of(*page)); !done)
    return std::unexpected(done.error());
  return std::vector<Written>{{s.out, page->size()}};
}

/// A file's name as the page asks for it.
std::string as_url(const std::string& name) {
  std::string url;
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                       std::string_view("-._~").find(c) != std::string_view::npos;
    url += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return url;
}

constexpr const char* kPoster = "poster.jpg";

/// The files of a folder beside the scene: those of the viewer's own folder, and the poster. Fails
/// where the scene has the name of one, or where one is there already.
Expected<std::vector<std::string>> files_of_folder(const WebSettings& s, const fs::path& source) {
  const fs::path folder(s.out);
  const std::string scene = fs::path(s.scene).filename().string();
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(source, error))
    names.push_back(entry.path().filename().string());
  if (error) return fail(source.string(), "", "cannot be read: " + error.message());
  std::ranges::sort(names);
  if (std::ranges::find(names, scene) != names.end() || scene == kPoster)
    return fail(s.scene, "", "the page has a file of that name: rename the scene");
  std::vector<std::string> all = names;
  all.push_back(scene);
  if (!s.no_poster) all.emplace_back(kPoster);
  for (const std::string& name : all)
    if (auto ok = check_overwrite(folder / name, s.force); !ok) return std::unexpected(ok.error());
  return names;
}

/// A folder of files for a static host.
Expected<std::vector<Written>> write_folder(const WebSettings& s, const std::string& viewer,
                                            const std::vector<std::string>& names, WebPage shown,
                                            std::span<const std::byte> scene,
                                            std::span<const std::byte> poster) {
  const fs::path folder(s.out), source = fs::path(viewer) / "page";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(s.out, "", "the folder cannot be made: " + error.message());
  std::vector<Written> written;
  const auto write = [&](const std::string& name, std::span<const std::byte> bytes) {
    written.push_back({(folder / name).string(), bytes.size()});
    return write_file_atomic(folder / name, bytes);
  };
  const std::string scene_name = fs::path(s.scene).filename().string();
  shown.scene = as_url(scene_name);
  if (!poster.empty()) shown.poster = kPoster;
  for (const std::string& name : names) {
    if (name == "index.html") continue;
    const auto bytes = read_file(source / name);
    if (!bytes) return std::unexpected(bytes.error());
    if (auto done = write(name, *bytes); !done) return std::unexpected(done.error());
  }
  const auto empty = text_of(source / "index.html");
  if (!empty) return std::unexpected(empty.error());
  const auto page = page_with((source / "index.html").string(), *empty, shown, {});
  if (!page) return std::unexpected(page.error());
  auto done = write(scene_name, scene);
  if (done && !poster.empty()) done = write(shown.poster, poster);
  if (done) done = write("index.html", bytes_of(*page));  // last: it names the others
  if (!done) return std::unexpected(done.error());
  return written;
}

/// True for the name of one page, false for that of a folder.
bool is_page(const std::string& name) {
  std::string extension = fs::path(name).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".html" || extension == ".htm";
}

Expected<void> check_address(const WebSettings& s, bool single) {
  if (s.address.empty()) return {};
  if (single)
    return fail(s.out, "--address",
                "is for a folder: a page of one file has no picture of its own address");
  if (!s.address.starts_with("https://") && !s.address.starts_with("http://"))
    return fail(s.address, "--address", "expected the address of a folder, as https://…");
  return {};
}

/// The scene as the page reads it, from its bytes. Fails on scenes of several files and on
/// checkpoints, which `fluxgs convert` reads.
Expected<SceneFile> read_as_page(const std::string& path, std::span<const std::byte> bytes) {
  auto scene = read_scene(bytes, path);
  if (scene) return scene;
  const auto elsewhere = read_scene_or_checkpoint(path);
  if (!elsewhere) return std::unexpected(elsewhere.error());
  return fail(path, "",
              fmt::format("a page shows a scene that is one file; `fluxgs convert {} scene.glb` "
                          "makes one of it",
                          shell_quoted(path)));
}

Expected<void> make_page(const WebSettings& s) {
  const bool single = is_page(s.out);
  if (auto ok = check_address(s, single); !ok) return ok;
  const auto viewer = web_viewer_folder();
  if (!viewer) return std::unexpected(viewer.error());
  std::vector<std::string> names;
  if (single) {
    if (auto ok = check_overwrite(s.out, s.force); !ok) return ok;
  } else {
    auto found = files_of_folder(s, fs::path(*viewer) / "page");
    if (!found) return std::unexpected(found.error());
    names = std::move(*found);
  }
  const auto bytes = read_file(s.scene);
  if (!bytes) return std::unexpected(bytes.error());
  const auto scene = read_as_page(s.scene, *bytes);
  if (!scene) return std::unexpected(scene.error());
  warn_of(s.scene, *scene);
  const glm::dvec3 background(s.background[0], s.background[1], s.background[2]);
  std::vector<std::byte> poster;
  if (!s.no_poster) {
    auto made = poster_of(s, *scene, background);
    if (!made) return std::unexpected(made.error());
    poster = std::move(*made);
  }
  const WebPage shown{.title = s.title.empty() ? fs::path(s.scene).stem().string() : s.title,
                      .background = hex(background),
                      .turntable = s.turntable,
                      .address = s.address};
  const auto written = single ? write_page(s, *viewer, shown, *bytes, poster)
                              : write_folder(s, *viewer, names, shown, *bytes, poster);
  if (!written) return std::unexpected(written.error());
  nlohmann::json files = nlohmann::json::array();
  for (const Written& w : *written) {
    files.push_back({{"file", w.file}, {"bytes", w.bytes}});
    if (!s.as_json) fmt::print("{}  {} bytes\n", w.file, w.bytes);
  }
  if (s.as_json) print_json({{"files", files}});
  return {};
}

}  // namespace

void add_web(CLI::App& app, Action& action) {
  auto s = std::make_shared<WebSettings>();
  CLI::App* command = app.add_subcommand("web", "Make a page for browsers of a scene");
  command->footer(
      "The viewer draws with WebGPU or WebGL 2 what `fluxgs view` draws. One .html holds\n"
      "everything and opens from a disk or a mail; a folder is for a web server, which needs\n"
      "no settings.\n"
      "Example: fluxgs web garden.glb -o garden.html\n"
      "Example: fluxgs web garden.glb -o site --title 'Our garden' --address "
      "https://example.org/garden");
  command->add_option("scene", s->scene, "the scene file")->required();
  command->add_option("-o,--out", s->out, "a file that ends in .html or .htm, or a folder")
      ->required();
  command->add_option("--title", s->title, "of the page (default: the scene's name)");
  command->add_option("--address", s->address,
                      "where the folder will lie, so that links to it have a picture in chats");
  command->add_flag("--turntable", s->turntable, "turn slowly from the start");
  command->add_flag("--no-poster", s->no_poster,
                    "no picture for the time until the scene is there");
  add_background_option(*command, s->background);
  add_renderer_options(*command, s->choice);
  command->add_flag("--force", s->force, "write over a page that is there");
  command->add_flag("--json", s->as_json, "print one JSON object");
  command->callback([s, &action] { action = [s] { return make_page(*s); }; });
}

}  // namespace fluxgs::cli
