#include "trainer/data/run_colmap.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "fluxgs/byte_reader.h"
#include "trainer/data/file_bytes.h"

extern char** environ;

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Run a program to its end without a shell, its output appended to a log file. Returns its exit
/// status, or −1 if it could not be started or was killed.
int run_program(const fs::path& program, std::vector<std::string> arguments, const fs::path& log) {
  std::vector<char*> argv;
  std::string name = program.string();
  argv.push_back(name.data());
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = 0;
  const int started = posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (started != 0) return -1;

  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// One step of the reconstruction: its command, and the option that keeps it off the GPU (COLMAP
/// needs a display or CUDA there), which COLMAP 3.12 renamed.
struct Step {
  std::string command;
  std::vector<std::string> arguments;
  std::vector<std::string> cpu_options;  // tried in order; empty: none needed
};

Expected<void> run_step(const fs::path& colmap, const Step& step, const fs::path& log) {
  spdlog::info("running colmap {} (log: {})", step.command, log.string());
  std::vector<std::string> arguments{step.command};
  arguments.insert(arguments.end(), step.arguments.begin(), step.arguments.end());
  if (step.cpu_options.empty() && run_program(colmap, arguments, log) == 0) return {};
  for (const std::string& option : step.cpu_options) {
    auto with_option = arguments;
    with_option.insert(with_option.end(), {option, "0"});
    if (run_program(colmap, with_option, log) == 0) return {};
  }
  return fail(log.string(), "", fmt::format("colmap {} failed; this log says why", step.command));
}

std::vector<Step> reconstruction_steps(const std::string& images, const std::string& database,
                                       const std::string& sparse) {
  return {{"feature_extractor",
           {"--database_path", database, "--image_path", images, "--ImageReader.single_camera", "1",
            "--ImageReader.camera_model", "OPENCV"},
           {"--SiftExtraction.use_gpu", "--FeatureExtraction.use_gpu"}},
          {"exhaustive_matcher",
           {"--database_path", database},
           {"--SiftMatching.use_gpu", "--FeatureMatching.use_gpu"}},
          {"mapper",
           {"--database_path", database, "--image_path", images, "--output_path", sparse},
           {}}};
}

/// A work folder without traces of an earlier, interrupted run.
Expected<void> prepare(const fs::path& work_folder, const fs::path& partial) {
  std::error_code error;
  fs::create_directories(work_folder, error);
  if (error) return fail(work_folder.string(), "", "cannot be created: " + error.message());
  fs::remove(work_folder / "database.db", error);
  fs::remove(work_folder / "log.txt", error);
  fs::remove_all(partial, error);
  fs::create_directories(partial, error);
  if (error) return fail(partial.string(), "", "cannot be created: " + error.message());
  return {};
}

}  // namespace

std::optional<fs::path> find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(folder.size() + 1, rest.size()));
    fs::path candidate = fs::path(folder) / name;
    if (!folder.empty() && is_file(candidate) && access(candidate.c_str(), X_OK) == 0)
      return candidate;
  }
  return std::nullopt;
}

std::optional<fs::path> largest_model(const fs::path& sparse) {
  std::optional<fs::path> best;
  std::uint64_t most = 0;
  for (int i = 0;; ++i) {
    const fs::path model = sparse / std::to_string(i);
    const auto head = read_prefix(model / "images.bin", 8);
    if (!head) return best;
    const std::uint64_t images = ByteReader(*head).take<std::uint64_t>().value_or(0);
    if (images > most || !best) {
      best = model;
      most = images;
    }
  }
}

Expected<void> run_colmap(const fs::path& images, const fs::path& work_folder) {
  const auto colmap = find_program("colmap");
  if (!colmap)
    return fail(images.string(), "",
                "images without camera poses (no sparse/0, no transforms.json); install COLMAP "
                "to recover the poses (apt install colmap) or give a folder that has them");
  const fs::path partial = work_folder / "sparse.partial", log = work_folder / "log.txt";
  if (const auto ok = prepare(work_folder, partial); !ok) return ok;
  for (const Step& step : reconstruction_steps(
           images.string(), (work_folder / "database.db").string(), partial.string()))
    if (const auto ok = run_step(*colmap, step, log); !ok) return ok;
  if (!largest_model(partial))
    return fail(log.string(), "",
                "COLMAP found no cameras; expected sharp images that overlap, from many sides");
  std::error_code error;
  fs::rename(partial, work_folder / "sparse", error);
  if (error) return fail(partial.string(), "", "cannot be renamed: " + error.message());
  return {};
}

}  // namespace fluxgs
