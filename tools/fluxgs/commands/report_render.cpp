// fluxgs report render: what each setting of the renderer costs and brings.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/frame_benchmark.h"
#include "gl/expected_chain.h"
#include "platform/host/host_context.h"
#include "tools/fluxgs/cameras/cameras.h"
#include "tools/fluxgs/cameras/orbit.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/commands/plot.h"
#include "tools/fluxgs/commands/report.h"
#include "tools/fluxgs/options/data_options.h"
#include "tools/fluxgs/options/renderers.h"
#include "tools/fluxgs/options/tuning_options.h"
#include "tools/fluxgs/terminal/json_file.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/core/planar_image.h"
#include "trainer/loss/photometric.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct RenderReport {
  std::string scene, plot, report, gl = "egl";
  DataOptions data;
  ImageSize size{640, 480};
  int views = 4, rounds = 7;
  std::vector<std::string> only;  // groups of rows; none: all
};

/// One setting: what differs from the exact defaults.
struct SettingRow {
  std::string group, name;
  TuningOptions tuning;
  bool kept_order = false;  ///< drawn with the order of a view as far away as tuning allows

  // The measurements
  std::vector<double> times;  ///< ms, a frame with the sort of its view
  double square_error = 0, ssim = 0, largest = 0, bytes = 0;
  double worst = std::numeric_limits<double>::infinity();  ///< dB, of the images
  int images = 0;
  bool on_front = false;

  double ms() const { return bench::summarize(times).median; }
  double psnr() const { return -10 * std::log10(square_error / images); }
};

template <class Change>
SettingRow row(std::string group, std::string name, const Change& change) {
  SettingRow made{.group = std::move(group), .name = std::move(name), .tuning = {}, .times = {}};
  made.tuning.format = "rgba16f";
  made.tuning.blend = "accurate";
  change(made.tuning);
  return made;
}

constexpr double kSamePsnr = 0.1;  // dB: less is no difference

constexpr const char* kDefaults = "defaults";
constexpr std::array kGroups = {kDefaults,         "phone",   "target", "key-bits", "sh-degree",
                                "splat-precision", "cut-off", "extent", "weight",   "scale",
                                "slices",          "sorter",  "re-sort"};

std::vector<SettingRow> all_rows(int sh_degree) {
  using T = TuningOptions;
  std::vector<SettingRow> rows;
  const auto add = [&](const char* group, std::string name, auto change) {
    rows.push_back(row(group, std::move(name), change));
  };
  add(kDefaults, "all exact, RGBA16F", [](T&) {});
  add(kDefaults, "the same once more", [](T&) {});  // shows how well times repeat
  add("phone", "a phone's defaults", [](T& t) {
    const auto phone = render::default_approximation({.tiles = true});
    t.format = "rgba8", t.blend = "half", t.key_bits = phone.key_bits;
  });
  add("target", "RGBA8, blended in float", [](T& t) { t.format = "rgba8"; });
  add("target", "RGBA8, blended in half", [](T& t) { t.format = "rgba8", t.blend = "half"; });
  add("target", "RGBA8, blended in RGBA8", [](T& t) { t.format = "rgba8", t.blend = "direct"; });
  add("target", "RGBA16F, blended in half", [](T& t) { t.blend = "half"; });
  for (const int bits : {10, 12, 14, 16, 20, 32})
    add("key-bits", fmt::format("{}-bit keys", bits), [&](T& t) { t.key_bits = bits; });
  for (int degree = 0; degree < sh_degree; ++degree)
    add("sh-degree", fmt::format("SH degree {}", degree), [&](T& t) { t.sh_degree = degree; });
  add("splat-precision", "half-precision splats", [](T& t) { t.splat_precision = "half"; });
  for (const int steps : {2, 4, 8, 16})
    add("cut-off", fmt::format("cut-off {}/255", steps),
        [&](T& t) { t.alpha_min = steps / 255.0; });
  for (const double sigmas : {3.0, 2.5, 2.0})
    add("extent", fmt::format("{} deviations", sigmas), [&](T& t) { t.max_deviations = sigmas; });
  for (const double weight : {0.5, 1.0, 2.0, 4.0})
    add("weight", fmt::format("weight {} or more", weight), [&](T& t) { t.min_weight = weight; });
  for (const double scale : {0.9, 0.75, 0.5})
    add("scale", fmt::format("scale {}", scale), [&](T& t) { t.scale = scale; });
  for (const int slices : {4, 8, 16}) {
    add("slices", fmt::format("front to back, {} slices", slices),
        [&](T& t) { t.slices = slices; });
  }
  add("slices", "8 slices, blended in half", [](T& t) { t.slices = 8, t.blend = "half"; });
  add("sorter", "CPU, waited for", [](T& t) { t.sorter = "cpu"; });
  add("sorter", "order in float64", [](T& t) { t.sorter = "exact"; });
  for (const double degrees : {0.5, 2.0, 8.0}) {
    add("re-sort", fmt::format("order {} degrees old", degrees),
        [&](T& t) { t.resort_degrees = degrees * 1.001; });
    rows.back().kept_order = true;
  }
  return rows;
}

/// The defaults, which the others are compared with, and the groups that were asked for.
std::vector<SettingRow> chosen_rows(int sh_degree, const std::vector<std::string>& only) {
  std::vector<SettingRow> rows = all_rows(sh_degree);
  if (only.empty()) return rows;
  std::erase_if(rows, [&](const SettingRow& r) {
    return r.group != kDefaults && std::ranges::find(only, r.group) == only.end();
  });
  return rows;
}

/// Draws with any settings: keeps a renderer for each set of programs.
class Gallery {
 public:
  static Expected<std::unique_ptr<Gallery>> open(const std::string& gl, const SplatCloud& cloud,
                                                 const RenderOptions& options) {
    const auto implementation = host::parse_host_gl(gl);
    if (!implementation) return std::unexpected(implementation.error());
    std::unique_ptr<Gallery> gallery(new Gallery(cloud, options));
    auto made = gl::assign_or_error(host::HostContext::create(*implementation), gallery->context_);
    if (!made) return std::unexpected(made.error());
    return gallery;
  }

  const std::string& renderer_string() const { return context_->renderer_string(); }

  /// False for slices that this OpenGL would draw as if they were off.
  Expected<bool> has(const TuningOptions& tuning) {
    if (auto ok = choose(tuning); !ok) return std::unexpected(ok.error());
    return renderer_->settings().slices == tuning.slices;
  }

  /// A frame of that row and view; the time of it in milliseconds.
  Expected<double> draw(const SettingRow& row, const Camera& view) {
    auto ready =
        gl::chain([&] { return choose(row.tuning); }, [&] { return fit(row.tuning, view); },
                  [&] { return prepare(row, view); });
    if (!ready) return std::unexpected(ready.error());
    Expected<void> drawn;
    const double ms = bench::milliseconds_of([&] {
      drawn = renderer_->draw(view, tuned(options_, row.tuning), target_);
      context_->api().Finish();
    });
    if (!drawn) return std::unexpected(drawn.error());
    return ms;
  }

  /// Image of the last frame.
  Expected<PlanarImage> image() const {
    const auto image = renderer_->read(target_);
    if (!image) return std::unexpected(image.error());
    return planes_of(*image);
  }
  Expected<double> bytes(const SettingRow& row, const Camera& view) const {
    const auto counts =
        bench::count_frame(*renderer_, cloud_, view, tuned(options_, row.tuning), target_);
    if (!counts) return std::unexpected(counts.error());
    return bench::model_traffic(*counts, renderer_->settings(), plan_of(target_)).immediate();
  }

 private:
  Gallery(const SplatCloud& cloud, const RenderOptions& options)
      : cloud_(cloud), options_(options) {}

  Expected<void> choose(const TuningOptions& tuning) {
    auto& slot =
        renderers_[{tuning.sorter, tuning.splat_precision, tuning.digit_bits, tuning.slices}];
    if (!slot) {
      auto made =
          gl::assign_or_error(render::Renderer::create(context_->api(), settings_of(tuning)), slot);
      if (made) made = slot->upload(cloud_);
      if (!made) return made;
      if (renderers_.size() == 1) warn_of_undrawable(*slot);
      slot->wait_for_sorts(true);
    }
    renderer_ = slot.get();
    return renderer_->set_approximation(settings_of(tuning).approximation);
  }

  Expected<void> fit(const TuningOptions& tuning, const Camera& view) {
    const auto now = std::tuple(tuning.format, tuning.blend, tuning.scale, tuning.slices > 1,
                                view.width, view.height);
    if (fitted_ == now) return {};
    fitted_ = now;
    return gl::assign_or_error(target_of(context_->api(), view.width, view.height, tuning),
                               target_);
  }

  /// An order of a view that lies just as far away as the row allows; for other rows nothing.
  Expected<void> prepare(const SettingRow& row, const Camera& view) {
    if (!row.kept_order) return {};
    const double angle = renderer_->settings().approximation.resort_motion / 1.001;
    const glm::dmat3 turn(std::cos(angle), 0, -std::sin(angle), 0, 1, 0, std::sin(angle), 0,
                          std::cos(angle));
    Camera before = view;
    before.rotation = turn * view.rotation;
    before.translation = turn * view.translation;
    renderer_->sort_anew();
    auto drawn = renderer_->draw(before, options_, target_);
    context_->api().Finish();
    return drawn;
  }

  const SplatCloud& cloud_;
  RenderOptions options_;
  std::unique_ptr<host::HostContext> context_;
  std::map<std::tuple<std::string, std::string, int, int>, std::unique_ptr<render::Renderer>>
      renderers_;
  render::Renderer* renderer_ = nullptr;
  render::RenderTarget target_;
  std::tuple<std::string, std::string, double, bool, int, int> fitted_;
};

/// Leaves out what this OpenGL cannot do, and says so.
Expected<void> drop_missing(std::vector<SettingRow>& rows, Gallery& gallery) {
  std::vector<SettingRow> left;
  for (SettingRow& row : rows) {
    const auto there = gallery.has(row.tuning);
    if (!there) return std::unexpected(there.error());
    if (*there)
      left.push_back(std::move(row));
    else
      spdlog::warn("warning: '{}' is left out: this OpenGL has no framebuffer fetch", row.name);
  }
  rows = std::move(left);
  return {};
}

Expected<void> measure_errors(std::vector<SettingRow>& rows, Gallery& gallery,
                              const SplatCloud& cloud, const std::vector<Camera>& views,
                              const RenderOptions& options, const Threads& threads,
                              const ProgressReport& bar) {
  const auto reference = *make_renderer({.renderer = "reference"}, cloud, options, threads);
  PhotometricLoss metrics(threads);
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto exact = reference(views[v]);
    if (!exact) return std::unexpected(exact.error());
    limit_to_displayable(*exact);
    for (SettingRow& row : rows) {
      const auto ms = gallery.draw(row, views[v]);
      if (!ms) return std::unexpected(ms.error());
      auto image = gallery.image();
      if (!image) return std::unexpected(image.error());
      limit_to_displayable(*image);
      const double found = psnr(*image, *exact);
      row.square_error += std::pow(10, -found / 10);
      row.worst = std::min(row.worst, found);
      row.largest = std::max(row.largest, largest_difference(*image, *exact));
      row.ssim += metrics.run(*image, *exact, 1).ssim;
      ++row.images;
      if (v > 0) continue;
      const auto bytes = gallery.bytes(row, views[v]);
      if (!bytes) return std::unexpected(bytes.error());
      row.bytes = *bytes;
    }
    bar(v + 1, views.size());
  }
  return {};
}

/// Every row in every round, so that a slow moment of the machine does not fall on one of them.
Expected<void> measure_times(std::vector<SettingRow>& rows, Gallery& gallery,
                             const std::vector<Camera>& views, int rounds,
                             const ProgressReport& bar) {
  for (int round = 0; round < rounds; ++round) {
    for (SettingRow& row : rows) {
      const auto ms = gallery.draw(row, views[static_cast<std::size_t>(round) % views.size()]);
      if (!ms) return std::unexpected(ms.error());
      row.times.push_back(*ms);
    }
    bar(static_cast<std::size_t>(round + 1), static_cast<std::size_t>(rounds));
  }
  return {};
}

/// By how much the time of the same work, the defaults', differs: a ratio of 1 or more.
double noise_of_times(const std::vector<SettingRow>& rows) {
  const double once = rows[0].ms(), again = rows[1].ms();
  return std::max(once, again) / std::min(once, again);
}

/// No other row is at least as exact and faster by more than times differ anyway.
void mark_front(std::vector<SettingRow>& rows) {
  const double noise = noise_of_times(rows);
  for (SettingRow& a : rows)
    a.on_front = std::ranges::none_of(rows, [&](const SettingRow& b) {
      const bool faster = b.ms() * noise < a.ms(), as_fast = b.ms() < a.ms() * noise;
      return (faster && b.psnr() >= a.psnr()) || (as_fast && b.psnr() > a.psnr() + kSamePsnr);
    });
}

json json_of(const SettingRow& r) {
  return {{"group", r.group},
          {"name", r.name},
          {"ms", r.ms()},
          {"ms_p95", bench::summarize(r.times).p95},
          {"bytes_per_frame", r.bytes},
          {"psnr", finite_or_null(r.psnr())},
          {"psnr_worst", finite_or_null(r.worst)},
          {"ssim", r.ssim / r.images},
          {"max_error", r.largest},
          {"on_front", r.on_front}};
}

void print_table(const std::vector<SettingRow>& rows, const std::string& gl) {
  fmt::print("{}\n{:<26} {:>9} {:>7} {:>9} {:>8} {:>8} {:>8} {:>9}\n", gl, "setting", "ms", "ratio",
             "MB/frame", "PSNR", "worst", "SSIM", "max error");
  for (const SettingRow& r : rows)
    fmt::print("{:<26} {:>9.2f} {:>7.2f} {:>9.1f} {:>8.2f} {:>8.2f} {:>8.5f} {:>9.5f}{}\n", r.name,
               r.ms(), r.ms() / rows.front().ms(), 1e-6 * r.bytes, r.psnr(), r.worst,
               r.ssim / r.images, r.largest, r.on_front ? "  Pareto" : "");
}

Plot plot_of(const std::vector<SettingRow>& rows, const std::string& scene, const std::string& gl) {
  Plot plot{.title = fmt::format("{} on {}", scene, gl),
            .x_label = "milliseconds a frame, sorted for its own view (median)",
            .y_label = "PSNR to the float64 reference, dB",
            .series = {}};
  PlotSeries front{.name = "Pareto front", .points = {}};
  for (const SettingRow& r : rows) {
    if (plot.series.empty() || plot.series.back().name != r.group)
      plot.series.push_back({.name = r.group, .points = {}, .line = false});
    plot.series.back().points.emplace_back(r.ms(), r.psnr());
    if (r.on_front) front.points.emplace_back(r.ms(), r.psnr());
  }
  std::ranges::sort(front.points);
  // Later ones are drawn over earlier ones: the front beneath, the defaults on top
  plot.series.push_back(std::move(front));
  std::ranges::reverse(plot.series);
  return plot;
}

std::vector<Camera> views_of(const RenderReport& s, const SplatCloud& cloud, const Dataset* data) {
  std::vector<Camera> all = evaluation_cameras(cloud, data), views;
  const auto count = std::min(all.size(), static_cast<std::size_t>(s.views));
  for (std::size_t i = 0; i < count; ++i)
    views.push_back(resized(all[i * all.size() / count], s.size));
  return views;
}

Expected<void> report(const RenderReport& s) {
  if (auto ok = check_report_outputs(s.plot, s.report); !ok) return ok;
  const auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  std::optional<Dataset> data;
  if (!s.data.folder.empty())
    if (auto loaded = gl::assign_or_error(load(s.data), data); !loaded) return loaded;
  const SplatCloud& cloud = scene->cloud;
  const std::vector<Camera> views = views_of(s, cloud, data ? &*data : nullptr);
  RenderOptions options;
  options.background = s.data.background_color();
  const auto gallery = Gallery::open(s.gl, cloud, options);
  if (!gallery) return std::unexpected(gallery.error());
  const Threads threads(s.data.threads);
  std::vector<SettingRow> rows = chosen_rows(cloud.sh_degree, s.only);
  auto done = gl::chain(
      [&] { return drop_missing(rows, **gallery); },
      [&] {
        return measure_errors(rows, **gallery, cloud, views, options, threads,
                              show_progress("views"));
      },
      [&] { return measure_times(rows, **gallery, views, s.rounds, show_progress("rounds")); });
  if (!done) return done;
  mark_front(rows);

  const std::string gl = (*gallery)->renderer_string();
  json numbers = {{"scene", s.scene},         {"splats", cloud.size()},
                  {"gl_renderer", gl},        {"size", {s.size.width, s.size.height}},
                  {"views", views.size()},    {"rounds", s.rounds},
                  {"settings", json::array()}};
  for (const SettingRow& r : rows) numbers["settings"].push_back(json_of(r));
  if (auto given = give_report(s.report, numbers, [&] { print_table(rows, gl); }); !given)
    return given;
  if (s.plot.empty()) return {};
  return write_plot(s.plot, plot_of(rows, std::filesystem::path(s.scene).filename().string(), gl));
}

}  // namespace

void add_report_render(CLI::App& app, Action& action) {
  auto s = std::make_shared<RenderReport>();
  CLI::App* command =
      app.add_subcommand("render", "Time, bytes and error of each setting of the renderer");
  command->footer(
      "Errors: RGBA16F images against the float64 reference (other formats only in the rows that\n"
      "name them). Times: medians of frames that are sorted for their own view and waited for.\n"
      "MB/frame: the traffic model of fluxgs bench for a GPU without tiles. \"Order N degrees "
      "old\":\n"
      "the splats are sorted for a camera that has turned by N degrees since. \"Pareto\": no "
      "other\n"
      "row is as exact and clearly faster.\n"
      "Example: fluxgs report render garden.glb --data captures/garden --plot render.png\n"
      "Example: fluxgs report render garden.glb --only defaults --rounds 1 --gl angle");
  command->add_option("scene", s->scene, "the scene file")->required();
  command->add_option("--data", s->data.folder, "a data set: views are those of its images");
  add_size_option(*command, s->size, "WIDTHxHEIGHT (default: 640x480)");
  command->add_option("--views", s->views, "number of views for the errors")
      ->check(whole_in(1, 12))
      ->capture_default_str();
  command->add_option("--rounds", s->rounds, "frames for each median time")
      ->check(whole_in(1, 10000))
      ->capture_default_str();
  command->add_option("--only", s->only, "only these groups of settings, besides the defaults")
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(kGroups.begin(), kGroups.end())));
  command->add_option("--gl", s->gl, "egl, osmesa or angle")
      ->check(CLI::IsMember(kGlNames))
      ->capture_default_str();
  command->add_option("--plot", s->plot, "write a plot of time against error: .png or .svg");
  command->add_option("--json", s->report, "write the results as JSON (-: standard output)");
  add_data_options(*command, s->data);
  command->callback([s, &action] { action = [s] { return report(*s); }; });
}

}  // namespace fluxgs::cli
