// adreno_report: tables of what adreno_statistics wrote, and how they compare with the baseline.
// Started by tools/adreno/report.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "fluxgs/io/file.h"
#include "tools/adreno/baseline.h"

namespace fluxgs::adreno {
namespace {

constexpr int kSkipped = 77;  // what ctest is told to take for a test that was skipped

struct Options {
  std::vector<std::string> logs;
  std::string baseline, json;
  bool check = false, update = false;
};

Expected<std::string> read_text(const std::string& file) {
  const auto bytes = read_file(file);
  if (!bytes) return std::unexpected(bytes.error());
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

Expected<void> write_text(const std::string& file, const std::string& text) {
  auto out = AtomicFile::create(file);
  if (!out) return std::unexpected(out.error());
  if (auto ok = out->write(std::as_bytes(std::span(text))); !ok) return ok;
  return out->commit();
}

Expected<std::vector<GpuStatistics>> read_logs(const std::vector<std::string>& logs) {
  std::vector<GpuStatistics> gpus;
  for (const std::string& log : logs) {
    const auto text = read_text(log);
    if (!text) return std::unexpected(text.error());
    auto gpu = parse_statistics(*text, log);
    if (!gpu) return std::unexpected(gpu.error());
    // The log's name says which GPU was asked for: GPU.log
    if (std::filesystem::path(log).stem() != gpu->gpu)
      return fail(log, "driver", "is that of an " + gpu->gpu);
    gpus.push_back(std::move(*gpu));
  }
  return gpus;
}

void print_table(const GpuStatistics& gpu) {
  fmt::print("Adreno {} as Mesa {} compiles for it\n", gpu.gpu.substr(1), gpu.mesa);
  fmt::print("  {:<22} {:<9} {:>6} {:>6} {:>5} {:>5} {:>6} {:>7} {:>7} {:>7} {:>7}\n", "program",
             "stage", "instr", "no nop", "half", "full", "waves", "sstall", "systall", "spills",
             "shared");
  for (const ShaderStatistics& s : gpu.shaders) {
    const std::string shared = s.stage == "compute" ? fmt::format("{}", s.shared_bytes) : "";
    fmt::print("  {:<22} {:<9} {:>6} {:>6} {:>5} {:>5} {:>6} {:>7} {:>7} {:>7} {:>7}\n", s.program,
               s.stage, s.instructions, s.without_nops, s.half_registers, s.full_registers, s.waves,
               s.short_stalls, s.long_stalls, s.spills, shared);
  }
  fmt::print("\n");
}

/// The exit status.
Expected<int> check(const std::string& file, const std::vector<GpuStatistics>& gpus) {
  const auto text = read_text(file);
  if (!text) return std::unexpected(text.error());
  const auto baseline = from_json(*text, file);
  if (!baseline) return std::unexpected(baseline.error());
  if (!same_compiler(baseline->front(), gpus.front())) {
    fmt::print(
        "skipped: the baseline is of Mesa {}, this is Mesa {}; numbers of different compilers "
        "cannot be compared (tools/adreno/report --update makes a new baseline)\n",
        baseline->front().mesa, gpus.front().mesa);
    return kSkipped;
  }
  const std::vector<std::string> found = regressions(*baseline, gpus);
  for (const std::string& line : found) fmt::print("worse: {}\n", line);
  if (found.empty()) {
    fmt::print("nothing is worse than the baseline\n");
    return 0;
  }
  fmt::print(
      "if that is meant, tools/adreno/report --update makes a new baseline, for a commit that says "
      "why\n");
  return 1;
}

Expected<int> run(const Options& options) {
  const auto gpus = read_logs(options.logs);
  if (!gpus) return std::unexpected(gpus.error());
  for (const GpuStatistics& gpu : *gpus) print_table(gpu);
  for (const std::string& file : {options.json, options.update ? options.baseline : ""}) {
    if (file.empty()) continue;
    if (auto ok = write_text(file, to_json(*gpus)); !ok) return std::unexpected(ok.error());
  }
  return options.check ? check(options.baseline, *gpus) : Expected<int>(0);
}

}  // namespace
}  // namespace fluxgs::adreno

int main(int argc, char** argv) {
  fluxgs::adreno::Options options;
  CLI::App app("Tables of what Mesa's compiler makes of the shaders; see tools/adreno/report");
  app.add_option("logs", options.logs, "GPU.log of each GPU, from adreno_statistics")->required();
  app.add_option("--baseline", options.baseline, "the committed numbers")->required();
  app.add_flag("--check", options.check, "compare with the baseline");
  app.add_flag("--update", options.update, "rewrite the baseline");
  app.add_option("--json", options.json, "also write the numbers to this file");
  CLI11_PARSE(app, argc, argv);
  const auto status = fluxgs::adreno::run(options);
  if (status) return *status;
  std::fprintf(stderr, "adreno: error: %s\n", status.error().message().c_str());
  return 1;
}
