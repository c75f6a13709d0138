// fluxgs report phone: what the app's benchmark measured on a device, beside the paper and an
// earlier run.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/self_test.h"
#include "tools/fluxgs/commands/phone_result.h"
#include "tools/fluxgs/commands/report.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/json_file.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

struct PhoneReport {
  std::string result, before, scene, report;
};

/// Flux-GS, tables of the Mip-NeRF 360 scenes (indoor, outdoor) and of the ablation (all of them):
/// off the screen, Snapdragon 8 Gen 3. The size of the image is not given.
struct PaperRow {
  const char* what;
  double splats, megabytes, fps;
};
constexpr PaperRow kPaper[] = {
    {"indoor", 0.22e6, 2.1, 147}, {"outdoor", 0.48e6, 4.6, 132}, {"all scenes", 0.36e6, 3.5, 139}};

std::optional<double> ratio(const PhoneRow& now, const PhoneResult* before) {
  if (before == nullptr) return std::nullopt;
  const auto old = std::ranges::find(before->rows, now.name(), &PhoneRow::name);
  if (old == before->rows.end()) return std::nullopt;
  return old->in_flight_ms / now.in_flight_ms;
}

struct SelfTest {
  std::string text;          ///< empty: was not asked for
  std::optional<bool> same;  ///< empty: is not known
};

json to_json(const PhoneResult& r, const PhoneResult* before, const SelfTest& test) {
  json rows = json::array();
  for (const PhoneRow& row : r.rows) {
    json j = {{"width", row.width},
              {"height", row.height},
              {"views", row.views},
              {"sorter", row.sorter},
              {"draw_fps", 1000 / row.in_flight_ms},
              {"in_flight_ms", row.in_flight_ms},
              {"draw_ms", row.draw_ms},
              {"sort_to_display_ms", row.sort_to_display_ms},
              {"pipelined_fps", 1000 / row.pipelined_ms}};
    if (const auto times = ratio(row, before)) j["speed_to_before"] = *times;
    rows.push_back(j);
  }
  json paper = json::array();
  for (const PaperRow& p : kPaper)
    paper.push_back(
        {{"scenes", p.what}, {"splats", p.splats}, {"bytes", p.megabytes * 1e6}, {"fps", p.fps}});
  return {{"device", r.device},
          {"driver", r.driver},
          {"driver_check", r.driver_check},
          {"scene", r.scene},
          {"splats", r.splats},
          {"bytes", r.bytes},
          {"app", r.app},
          {"blended_in", r.blended_in},
          {"stopped", r.stopped},
          {"rows", rows},
          {"paper", paper},
          {"self_test_same", test.same ? json(*test.same) : json(nullptr)}};
}

void print_rows(const PhoneResult& r, const PhoneResult* before) {
  fmt::print("{:<12} {:<6} {:<6} {:>9} {:>9} {:>14} {:>13}{}\n", "size", "views", "sorter",
             "draw fps", "draw ms", "sort to display", "pipelined fps",
             before == nullptr ? "" : "  x before");
  for (const PhoneRow& row : r.rows) {
    fmt::print("{:<12} {:<6} {:<6} {:>9.1f} {:>9.2f} {:>11.2f} ms {:>13.1f}",
               fmt::format("{}x{}", row.width, row.height), row.views, row.sorter,
               1000 / row.in_flight_ms, row.draw_ms, row.sort_to_display_ms,
               1000 / row.pipelined_ms);
    if (const auto times = ratio(row, before)) fmt::print("  {:>8.2f}", *times);
    fmt::print("\n");
  }
}

void print_report(const PhoneResult& r, const PhoneResult* before,
                  const std::vector<std::string>& unlike, const SelfTest& test) {
  fmt::print("{}, {}\n", r.device, r.driver);
  fmt::print("{}: {} splats, {:.2f} MB; app {}; heat {} before, {} after\n", r.scene, r.splats,
             static_cast<double>(r.bytes) / 1e6, r.app, r.heat_before, r.heat_after);
  if (!r.driver_check.empty()) fmt::print("driver: {}\n", r.driver_check);
  if (!r.blended_in.empty()) fmt::print("layers blended in {}\n", r.blended_in);
  if (!r.stopped.empty()) fmt::print("NOT WHOLE, it was stopped: {}\n", r.stopped);
  fmt::print("\n");
  print_rows(r, before);
  fmt::print("\npaper (Flux-GS, Snapdragon 8 Gen 3, off the screen):");
  for (const PaperRow& p : kPaper)
    fmt::print(" {} {:.0f} fps with {:.2f} M splats{}", p.what, p.fps, p.splats / 1e6,
               &p == std::end(kPaper) - 1 ? "\n" : ";");
  for (const std::string& difference : unlike) fmt::print("compared with: {}\n", difference);
  if (!test.text.empty()) fmt::print("self-test: {}\n", test.text);
}

/// Compares the device's decoding, sorting and projection with this machine's.
Expected<SelfTest> compare_self_tests(const PhoneReport& s, const PhoneResult& r) {
  if (s.scene.empty()) return SelfTest{};
  if (r.self_test.empty()) return SelfTest{"the result has none", {}};
  if (const auto error = r.self_test.find("error"); error != r.self_test.end())
    return SelfTest{"failed on the device: " + error->second, false};
  auto scene = load_scene(s.scene);
  if (!scene) return std::unexpected(scene.error());
  const json here =
      json::parse(to_json(bench::self_test(render::cloud_to_draw(std::move(scene->cloud)))));
  for (const auto& [key, value] : here.items()) {
    const auto there = r.self_test.find(key);
    if (there == r.self_test.end() ||
        there->second != (value.is_string() ? value.get<std::string>() : value.dump()))
      return SelfTest{"the device computes SOMETHING ELSE than this machine does", false};
  }
  return SelfTest{"the device computes bit for bit what this machine does", true};
}

std::string reason_of(const PhoneResult& r) {
  return r.stopped.empty() ? "the run has no rows" : "it was stopped, " + r.stopped;
}

/// Differences that make two results hard to compare.
std::vector<std::string> differences(const PhoneResult& now, const PhoneResult& before) {
  std::vector<std::string> found;
  const auto look = [&](const char* what, const auto& a, const auto& b) {
    if (a != b) found.push_back(fmt::format("{} {} instead of {}", what, a, b));
  };
  look("device", now.device, before.device);
  look("driver", now.driver, before.driver);
  look("app", now.app, before.app);
  look("scene", now.scene, before.scene);
  look("splats", now.splats, before.splats);
  look("bytes", now.bytes, before.bytes);
  look("warm-up frames", now.warmup, before.warmup);
  look("measured frames", now.frames, before.frames);
  look("thermal status", now.heat_before, before.heat_before);
  const auto place = [](const PhoneResult& r) {
    return r.beside_another ? "split screen" : "full";
  };
  if (!now.blended_in.empty() && !before.blended_in.empty())
    look("layers blended in", now.blended_in, before.blended_in);
  look("screen", std::string_view(place(now)), std::string_view(place(before)));
  if (!before.stopped.empty()) found.push_back("the earlier run was stopped: " + before.stopped);
  return found;
}

Expected<PhoneResult> read_result(const std::string& path) {
  const auto value = read_json(path);
  if (!value) return std::unexpected(value.error());
  return phone_result(*value, path);
}

/// The numbers must not take the place of what they are made of.
Expected<void> check_paths(const PhoneReport& s) {
  if (s.report.empty() || s.report == "-") return {};
  std::error_code ignored;
  for (const std::string& input : {s.result, s.before, s.scene})
    if (!input.empty() && std::filesystem::equivalent(s.report, input, ignored))
      return fail(s.report, "--json", "is one of the files that are read");
  return check_report_outputs("", s.report);
}

Expected<void> report(const PhoneReport& s) {
  if (auto ok = check_paths(s); !ok) return ok;
  const auto result = read_result(s.result);
  if (!result) return std::unexpected(result.error());
  std::optional<PhoneResult> before;
  if (!s.before.empty()) {
    auto earlier = read_result(s.before);
    if (!earlier) return std::unexpected(earlier.error());
    // The same scene may have been given another name, by a file picker say
    if (earlier->scene != result->scene && earlier->splats != result->splats)
      return fail(
          s.before, "scene",
          fmt::format("is {}; expected that of {}, {}", earlier->scene, s.result, result->scene));
    before = std::move(*earlier);
  }
  const auto test = compare_self_tests(s, *result);
  if (!test) return std::unexpected(test.error());
  const PhoneResult* earlier = before ? &*before : nullptr;
  const auto unlike = before ? differences(*result, *before) : std::vector<std::string>();
  auto given = give_report(s.report, to_json(*result, earlier, *test),
                           [&] { print_report(*result, earlier, unlike, *test); });
  if (given && test->same == false) return fail(s.result, "self_test", test->text);
  if (given && result->rows.empty())
    return fail(s.result, "rows", "nothing was measured: " + reason_of(*result));
  return given;
}

}  // namespace

void add_report_phone(CLI::App& app, Action& action) {
  auto s = std::make_shared<PhoneReport>();
  CLI::App* command = app.add_subcommand(
      "phone", "Results of the app's benchmark, beside the paper's and an earlier run's");
  command->footer(
      "RESULT is the JSON that the app saves or shares; tools/phone-benchmark fetches one from a\n"
      "connected device. draw: one frame, already sorted. sort to display: from a new view to its\n"
      "finished image. pipelined: mean of successive frames. All but pipelined are medians.\n"
      "Example: fluxgs report phone garden.json --before last-week.json --scene garden.glb");
  command->add_option("result", s->result, "the app's result")->required();
  command->add_option("--before", s->before, "an earlier result of the same scene");
  command->add_option("--scene", s->scene,
                      "the scene file, to compare the device's results with this machine's");
  command->add_option("--json", s->report, "write the results as JSON (-: standard output)");
  command->callback([s, &action] { action = [s] { return report(*s); }; });
}

}  // namespace fluxgs::cli
