#include "trainer/data/photos/run_colmap.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fstream>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "fluxgs/io/file.h"
#include "trainer/core/median.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/photos/colmap_program.h"
#include "trainer/data/photos/match_pairs.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// On a CPU the comparison of a pair takes the product of its features.
constexpr int kFeaturesOnCpu = 4096, kFeaturesOnGpu = 8192;
constexpr int kFewFeatures = 300;  // a photo; sharp ones of textured things have thousands
/// Fewer photos do not hold the eight numbers of COLMAP's OPENCV camera.
constexpr std::size_t kPhotosForFullLens = 5;

/// The number behind a text in a line, if there is one.
std::optional<int> number_after(std::string_view line, std::string_view text) {
  const std::size_t at = line.find(text);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view rest = line.substr(at + text.size());
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  int value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

/// Number of photos that are registered once this line's is: "Registering image #12 (5)" of COLMAP
/// 3, "Registering image #12 (num_reg_frames=5)" of COLMAP 4.
std::optional<int> registered_in(std::string_view line) {
  const std::size_t at = line.find("Registering image");
  if (at == std::string_view::npos) return std::nullopt;
  line.remove_prefix(at);
  const auto count = number_after(line, "=");
  return count ? count : number_after(line, "(");
}

class ColmapRun {
 public:
  ColmapRun(ColmapProgram colmap, const std::vector<PreparedPhoto>& photos, fs::path work,
            ColmapState& state, const StepReport& report)
      : colmap_(std::move(colmap)),
        photos_(photos),
        work_(std::move(work)),
        state_(state),
        report_(report) {}

  Expected<void> extract_features();
  Expected<void> match();
  Expected<void> map();

 private:
  fs::path database() const { return work_ / "database.db"; }
  fs::path images() const { return work_ / "images"; }
  fs::path log() const { return work_ / "log.txt"; }
  void report(const char* step, const char* unit, std::size_t done, std::size_t total) const {
    if (report_ && total > 0) report_(step, unit, std::min(done, total), total);
  }
  Expected<void> run_on_gpu_or_cpu(const std::string& command, std::vector<std::string> arguments,
                                   const std::string& gpu_option,
                                   const ColmapProgram::LineSink& on_line);
  Expected<void> extract(const std::string& camera, const std::vector<const PreparedPhoto*>& group);
  std::vector<std::string> camera_options(const std::vector<const PreparedPhoto*>& group) const;
  std::vector<std::string> unmatched_pairs();
  Expected<void> match_some(std::span<const std::string> pairs, const std::string& gpu_option);
  Error why_no_poses() const;

  const ColmapProgram colmap_;
  const std::vector<PreparedPhoto>& photos_;
  const fs::path work_;
  ColmapState& state_;
  const StepReport& report_;
  bool gpu_ = colmap_.has_gpu();
};

Expected<void> ColmapRun::run_on_gpu_or_cpu(const std::string& command,
                                            std::vector<std::string> arguments,
                                            const std::string& gpu_option,
                                            const ColmapProgram::LineSink& on_line) {
  if (gpu_option.empty()) return colmap_.run(command, arguments, on_line);
  arguments.insert(arguments.end(), {gpu_option, gpu_ ? "1" : "0"});
  auto done = colmap_.run(command, arguments, on_line);
  if (done || !gpu_) return done;
  spdlog::warn("warning: {}; trying without the GPU", done.error().message());
  gpu_ = false;
  arguments.back() = "0";
  return colmap_.run(command, arguments, on_line);
}

/// Options for the camera of a group whose photos are the first of it.
std::vector<std::string> ColmapRun::camera_options(
    const std::vector<const PreparedPhoto*>& group) const {
  const bool full = group.size() >= kPhotosForFullLens;
  std::vector<std::string> options{"--ImageReader.camera_model", full ? "OPENCV" : "SIMPLE_RADIAL"};
  const PreparedPhoto& photo = *group.front();
  if (photo.focal <= 0) return options;
  const std::string centre = fmt::format("{},{}", 0.5 * photo.size.width, 0.5 * photo.size.height);
  options.push_back("--ImageReader.camera_params");
  options.push_back(full ? fmt::format("{0},{0},{1},0,0,0,0", photo.focal, centre)
                         : fmt::format("{},{},0", photo.focal, centre));
  return options;
}

/// One camera's photos: COLMAP then takes its lens as the same for all of them.
Expected<void> ColmapRun::extract(const std::string& camera,
                                  const std::vector<const PreparedPhoto*>& group) {
  std::string names;
  for (const PreparedPhoto* photo : group) names += photo->copy + "\n";
  const fs::path list = work_ / "photos.txt";
  if (auto ok = write_file_atomic(list, std::as_bytes(std::span(names))); !ok) return ok;

  const auto known = std::ranges::find(state_.cameras, camera);
  const auto number = known - state_.cameras.begin() + 1;
  const bool is_new = known == state_.cameras.end();
  if (is_new) {
    state_.cameras.push_back(camera);
    if (auto ok = write_colmap_state(work_, state_); !ok) return ok;
  }
  std::vector<std::string> common{"--database_path",
                                  database(),
                                  "--image_path",
                                  images(),
                                  "--image_list_path",
                                  list,
                                  "--ImageReader.single_camera",
                                  "1",
                                  "--SiftExtraction.max_num_features",
                                  std::to_string(gpu_ ? kFeaturesOnGpu : kFeaturesOnCpu)};
  const std::size_t before = state_.features.size();
  std::map<std::string, int> counts;
  std::size_t started = 0;
  std::string name;  // of the photo that the lines are about
  const ColmapProgram::LineSink on_line = [&](std::string_view line) {
    if (line.find("Processed file") != std::string_view::npos) {
      report("features", "photos", before + started, photos_.size());
      ++started;
    }
    if (const std::size_t at = line.find("Name:"); at != std::string_view::npos)
      name = line.substr(std::min(line.find_first_not_of(' ', at + 5), line.size()));
    if (const auto count = number_after(line, "Features:")) counts[name] = *count;
  };
  const std::string gpu_option = colmap_.option("feature_extractor", "xtraction.use_gpu");
  const auto run_with = [&](const std::vector<std::string>& more) {
    auto arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    started = 0;
    return run_on_gpu_or_cpu("feature_extractor", arguments, gpu_option, on_line);
  };
  Expected<void> done = fail("", "", "");
  if (!is_new) done = run_with({"--ImageReader.existing_camera_id", std::to_string(number)});
  // An interrupted run may have noted a camera before COLMAP did
  if (!done) done = run_with(camera_options(group));
  if (!done) return done;
  for (const PreparedPhoto* photo : group)
    state_.features[photo->copy] = counts.contains(photo->copy) ? counts[photo->copy] : -1;
  return write_colmap_state(work_, state_);
}

Expected<void> ColmapRun::extract_features() {
  std::vector<std::string> order;
  std::map<std::string, std::vector<const PreparedPhoto*>> groups;
  for (const PreparedPhoto& photo : photos_) {
    if (state_.features.contains(photo.copy)) continue;
    auto& group = groups[photo.camera];
    if (group.empty()) order.push_back(photo.camera);
    group.push_back(&photo);
  }
  // Cameras that COLMAP has keep their numbers
  std::ranges::stable_partition(order, [&](const std::string& camera) {
    return std::ranges::find(state_.cameras, camera) != state_.cameras.end();
  });
  for (const std::string& camera : order)
    if (auto ok = extract(camera, groups[camera]); !ok) return ok;
  report("features", "photos", photos_.size(), photos_.size());
  return {};
}

/// Lines "a.jpg b.jpg", without those that were compared before.
std::vector<std::string> ColmapRun::unmatched_pairs() {
  std::set<std::string> matched;
  if (const auto text = read_text(work_ / "matched.txt")) {
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);) matched.insert(line);
  }
  std::vector<std::string> pairs;
  for (const auto& [a, b] : match_pairs(photos_, images(), report_)) {
    const auto copy = [&](int i) { return photos_[static_cast<std::size_t>(i)].copy; };
    std::string line = copy(a) + " " + copy(b);
    if (!matched.contains(line) && !matched.contains(copy(b) + " " + copy(a)))
      pairs.push_back(std::move(line));
  }
  return pairs;
}

Expected<void> ColmapRun::match_some(std::span<const std::string> pairs,
                                     const std::string& gpu_option) {
  const std::string text = fmt::format("{}\n", fmt::join(pairs, "\n"));
  const fs::path list = work_ / "pairs.txt";
  if (auto ok = write_file_atomic(list, std::as_bytes(std::span(text))); !ok) return ok;
  if (auto ok = run_on_gpu_or_cpu(
          "matches_importer",
          {"--database_path", database(), "--match_list_path", list, "--match_type", "pairs"},
          gpu_option, {});
      !ok)
    return ok;
  std::ofstream matched(work_ / "matched.txt", std::ios::binary | std::ios::app);
  if (!(matched << text).flush())
    return fail((work_ / "matched.txt").string(), "", "cannot be written");
  return {};
}

/// COLMAP keeps the matches of a command when it ends: each command gets some seconds of work.
Expected<void> ColmapRun::match() {
  using Clock = std::chrono::steady_clock;
  constexpr double kSeconds = 8;
  const std::vector<std::string> pairs = unmatched_pairs();
  const std::string gpu_option = colmap_.option("matches_importer", "Matching.use_gpu");
  std::size_t some = 20;
  for (std::size_t done = 0; done < pairs.size();) {
    report("matches", "pairs", done, pairs.size());
    const Clock::time_point start = Clock::now();
    const auto next = std::span(pairs).subspan(done, std::min(some, pairs.size() - done));
    if (auto ok = match_some(next, gpu_option); !ok) return ok;
    done += next.size();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    const double factor = std::clamp(kSeconds / std::max(seconds, 0.01), 0.5, 4.0);
    some = std::max<std::size_t>(1, static_cast<std::size_t>(factor * static_cast<double>(some)));
  }
  report("matches", "pairs", pairs.size(), pairs.size());
  return {};
}

Expected<void> ColmapRun::map() {
  const fs::path partial = work_ / "sparse.partial", sparse = work_ / "sparse";
  std::error_code error;
  fs::remove_all(partial, error);
  fs::create_directories(partial, error);
  if (error) return fail(partial.string(), "", "cannot be created: " + error.message());
  std::size_t most = 0;
  int status = 0;
  report("poses", "photos", 0, photos_.size());
  std::vector<std::string> arguments{"--database_path", database(),      "--image_path",
                                     images(),          "--output_path", partial};
  // By default COLMAP adjusts until nothing changes at all, which takes most of its time
  if (const std::string tolerance = colmap_.option("mapper", "ba_global_function_tolerance");
      !tolerance.empty())
    arguments.insert(arguments.end(), {tolerance, "1e-6"});
  const auto ended = colmap_.run(
      "mapper", arguments,
      [&](std::string_view line) {
        if (const auto count = registered_in(line); count && *count > 0) {
          most = std::max(most, static_cast<std::size_t>(*count));
          report("poses", "photos", std::min(most, photos_.size() - 1), photos_.size());
        }
      },
      &status);
  report("poses", "photos", photos_.size(), photos_.size());
  // The mapper's status is that of a failure where it finds nothing
  if (status < 0) return ended;
  if (colmap_models(partial).empty()) return std::unexpected(why_no_poses());
  if (!ended) return ended;
  fs::remove_all(sparse, error);
  fs::rename(partial, sparse, error);
  if (error) return fail(partial.string(), "", "cannot be renamed: " + error.message());
  return {};
}

Error ColmapRun::why_no_poses() const {
  std::vector<double> counts;
  for (const PreparedPhoto& photo : photos_)
    if (const auto found = state_.features.find(photo.copy); found != state_.features.end())
      if (found->second >= 0) counts.push_back(found->second);
  const auto typical = median(counts);
  const std::string why =
      typical && *typical < kFewFeatures
          ? fmt::format(
                "the photos show too little detail: {} points in a typical one; expected "
                "sharp, well lit photos of things with a pattern",
                *typical)
          : std::string(
                "the photos have too little in common or are taken from one place; expected photos "
                "that overlap by two thirds, each taken a step away from the last");
  return {log().string(), "",
          fmt::format("COLMAP found no poses for {} photos: {}", photos_.size(), why)};
}

}  // namespace

Expected<void> run_colmap(const std::vector<PreparedPhoto>& photos, const fs::path& work,
                          ColmapState& state, const StepReport& report) {
  const fs::path log = work / "log.txt";
  std::error_code ignored;
  fs::remove(log, ignored);
  auto colmap = ColmapProgram::find(log);
  if (!colmap) return std::unexpected(colmap.error());
  if (!is_file(work / "database.db")) {
    fs::remove(work / "matched.txt", ignored);
    state.features.clear();
    state.cameras.clear();
  }
  ColmapRun run(std::move(*colmap), photos, work, state, report);
  if (auto ok = run.extract_features(); !ok) return ok;
  if (auto ok = run.match(); !ok) return ok;
  return run.map();
}

}  // namespace fluxgs
