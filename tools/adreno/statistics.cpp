#include "tools/adreno/statistics.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include <fmt/format.h>

namespace fluxgs::adreno {
namespace {

// The names that Mesa gives to the stages of its shaders (ir3_shader_stage).
const std::map<std::string_view, const char*> kStages = {
    {"CL", "compute"}, {"VERT", "vertex"}, {"BVERT", "binning"}, {"FRAG", "fragment"}};

std::optional<std::string_view> after(std::string_view line, std::string_view label) {
  const std::size_t at = line.find(label);
  if (at == std::string_view::npos) return std::nullopt;
  return line.substr(at + label.size());
}

std::optional<int> number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

/// "53 inst, 34 nops, …" → {"inst": 53, "nops": 34, …}
std::map<std::string_view, int> counts(std::string_view list) {
  std::map<std::string_view, int> all;
  while (!list.empty()) {
    const std::string_view item = list.substr(0, list.find(", "));
    list.remove_prefix(std::min(list.size(), item.size() + 2));
    const std::size_t space = item.find(' ');
    if (space == std::string_view::npos) continue;
    if (const auto value = number(item)) all[item.substr(space + 1)] = *value;
  }
  return all;
}

/// Reads lines into statistics. Fails with what is wrong, without the place.
class Parser {
 public:
  explicit Parser(const std::string& file) : file_(file) {}

  Expected<void> line(std::string_view text) {
    if (const auto name = after(text, "driver: FD")) {
      result_.gpu = fmt::format("a{}", *name);
    } else if (const auto version = after(text, "version: ")) {
      const auto mesa = after(*version, "Mesa ");
      result_.mesa = mesa.value_or(*version);
    } else if (const auto program = after(text, "program: ")) {
      if (auto ok = end_program(); !ok) return ok;
      program_ = *program;
      first_ = result_.shaders.size();
      shared_bytes_ = 0;
    } else if (const auto bytes = after(text, " shared_size: ")) {
      shared_bytes_ = number(*bytes).value_or(0);
    } else if (const auto message = after(text, "message: ")) {
      return shader(*message);
    }
    return {};
  }

  Expected<GpuStatistics> finish() {
    if (auto ok = end_program(); !ok) return std::unexpected(ok.error());
    if (result_.gpu.empty()) return fail(file_, "driver", "is not that of an Adreno");
    if (result_.shaders.empty()) return fail(file_, "programs", "there are none");
    return std::move(result_);
  }

 private:
  Expected<void> shader(std::string_view message) {
    const std::size_t colon = message.find(" shader: ");
    const auto stage =
        colon == std::string_view::npos ? kStages.end() : kStages.find(message.substr(0, colon));
    if (stage == kStages.end()) return {};  // The driver speaks of other things as well
    const auto count = counts(message.substr(colon + 9));
    ShaderStatistics s{.program = program_, .stage = stage->second};
    int stores = 0, loads = 0;
    for (const auto& [label, value] : {std::pair<const char*, int*>{"inst", &s.instructions},
                                       {"non-nops", &s.without_nops},
                                       {"half", &s.half_registers},
                                       {"full", &s.full_registers},
                                       {"waves", &s.waves},
                                       {"sstall", &s.short_stalls},
                                       {"systall", &s.long_stalls},
                                       {"stp", &stores},
                                       {"ldp", &loads}}) {
      const auto found = count.find(label);
      if (found == count.end()) {
        return fail(file_, program_,
                    "the driver's line has no \"" + std::string(label) +
                        "\": another version of Mesa? " + std::string(message));
      }
      *value = found->second;
    }
    s.spills = stores + loads;
    if (s.stage == "compute") s.shared_bytes = shared_bytes_;
    result_.shaders.push_back(std::move(s));
    return {};
  }

  // A compute shader is one, a vertex and a fragment shader are three, with the one for binning.
  Expected<void> end_program() {
    if (program_.empty()) return {};
    std::string stages;
    for (std::size_t i = first_; i < result_.shaders.size(); ++i)
      stages += (stages.empty() ? "" : " ") + result_.shaders[i].stage;
    if (stages == "compute" || stages == "vertex binning fragment") return {};
    return fail(file_, program_,
                "has statistics for \"" + stages +
                    "\"; \"compute\" or \"vertex binning fragment\" was expected");
  }

  const std::string& file_;
  GpuStatistics result_;
  std::string program_;
  std::size_t first_ = 0;  // of the program's shaders
  int shared_bytes_ = 0;
};

}  // namespace

Expected<GpuStatistics> parse_statistics(std::string_view log, const std::string& file) {
  Parser parser(file);
  while (!log.empty()) {
    const std::string_view line = log.substr(0, log.find('\n'));
    log.remove_prefix(std::min(log.size(), line.size() + 1));
    if (auto ok = parser.line(line); !ok) return std::unexpected(ok.error());
  }
  return parser.finish();
}

}  // namespace fluxgs::adreno
