#include "trainer/data/photos/colmap_program.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Cuts a stream of text into lines, none longer than a few thousand bytes.
class LineCutter {
 public:
  explicit LineCutter(const ColmapProgram::LineSink& sink) : sink_(sink) {}

  void add(std::string_view text) {
    constexpr std::size_t kLongest = 4096;
    for (const char c : text) {
      if (c != '\n' && line_.size() < kLongest) line_ += c;
      if (c == '\n') finish();
    }
  }
  void finish() {
    sink_(line_);
    line_.clear();
  }

 private:
  const ColmapProgram::LineSink& sink_;
  std::string line_;
};

/// The last line that complains, or the last one at all.
class LastComplaint {
 public:
  void add(std::string_view line) {
    if (line.find_first_not_of(" \t\r=*-") == std::string_view::npos) return;
    last_ = line;
    for (const std::string_view word : {"ERROR", "rror:", "Check failed", "terminate", "annot "})
      if (line.find(word) != std::string_view::npos) complaint_ = line;
  }
  std::string text() const { return one_line(complaint_.empty() ? last_ : complaint_, 160); }

 private:
  std::string last_, complaint_;
};

std::string output_of(const fs::path& program, const std::vector<std::string>& arguments) {
  constexpr std::size_t kMost = 1 << 20;
  std::string text;
  run(
      {program, arguments, "/dev/null"},
      [&](std::string_view more) {
        if (text.size() < kMost) text += more;
      },
      Captured::output_and_errors);
  return text;
}

bool has_nvidia_gpu() {
  const auto program = find_program("nvidia-smi");
  return program && output_of(*program, {"-L"}).starts_with("GPU ");
}

}  // namespace

Expected<void> check_colmap_installed(const fs::path& photos) {
  if (find_program("colmap")) return {};
  return fail(photos.string(), "",
              "images without camera poses (no sparse/0, no transforms.json) need COLMAP, which is "
              "not installed (apt install colmap)");
}

Expected<ColmapProgram> ColmapProgram::find(const fs::path& log) {
  const auto program = find_program("colmap");
  if (!program) return std::unexpected(check_colmap_installed("").error());
  ColmapProgram colmap(*program, log);
  const std::string help = output_of(*program, {"-h"});
  colmap.has_gpu_ = help.find("with CUDA") != std::string::npos && has_nvidia_gpu();
  return colmap;
}

std::string ColmapProgram::help_of(const std::string& command) const {
  return output_of(program_, {command, "-h"});
}

std::string ColmapProgram::option(const std::string& command, std::string_view end) const {
  const std::string help = help_of(command);
  for (std::size_t at = 0; (at = help.find("--", at)) != std::string::npos;) {
    const std::size_t stop = std::min(help.find_first_of(" \n=\t", at), help.size());
    const std::string name = help.substr(at, stop - at);
    if (name.ends_with(end)) return name;
    at = stop;
  }
  return {};
}

Expected<void> ColmapProgram::run(const std::string& command,
                                  const std::vector<std::string>& arguments,
                                  const LineSink& on_line, int* status) const {
  std::ofstream log(log_, std::ios::binary | std::ios::app);
  std::vector<std::string> all{command};
  all.insert(all.end(), arguments.begin(), arguments.end());
  LastComplaint complaint;
  const LineSink sink = [&](std::string_view line) {
    complaint.add(line);
    if (on_line) on_line(line);
  };
  LineCutter lines(sink);
  const ProcessEnd end = fluxgs::run(
      {program_, all, "/dev/null"},
      [&](std::string_view text) {
        log.write(text.data(), static_cast<std::streamsize>(text.size())).flush();
        lines.add(text);
      },
      Captured::output_and_errors);
  lines.finish();
  if (status) *status = end.status;
  if (end.status == 0) return {};
  const std::string last = complaint.text();
  return fail(log_.string(), "",
              fmt::format("colmap {} {}{}", command, end.text(), last.empty() ? "" : ": " + last));
}

}  // namespace fluxgs
