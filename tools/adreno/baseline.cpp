#include "tools/adreno/baseline.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fluxgs::adreno {
namespace {

using nlohmann::ordered_json;

enum class Wanted { fewer, more, none, any };

struct Number {
  const char* key;
  int ShaderStatistics::* member;
  Wanted wanted;
};

constexpr std::array kNumbers = {
    Number{"instructions", &ShaderStatistics::instructions, Wanted::fewer},
    Number{"without_nops", &ShaderStatistics::without_nops, Wanted::fewer},
    Number{"half_registers", &ShaderStatistics::half_registers, Wanted::fewer},
    Number{"full_registers", &ShaderStatistics::full_registers, Wanted::fewer},
    Number{"waves", &ShaderStatistics::waves, Wanted::more},
    Number{"short_stalls", &ShaderStatistics::short_stalls, Wanted::fewer},
    Number{"long_stalls", &ShaderStatistics::long_stalls, Wanted::fewer},
    Number{"spills", &ShaderStatistics::spills, Wanted::none},
    Number{"shared_bytes", &ShaderStatistics::shared_bytes, Wanted::any}};

bool worse(Wanted wanted, int before, int now) {
  switch (wanted) {
    case Wanted::fewer:
      return now >= before + 2 && 100 * now > 105 * before;
    case Wanted::more:
      return now < before;
    case Wanted::none:
      return now > 0;
    case Wanted::any:
      return false;
  }
  return false;
}

const ShaderStatistics* find(const GpuStatistics& gpu, const ShaderStatistics& like) {
  const auto found = std::ranges::find_if(gpu.shaders, [&](const ShaderStatistics& s) {
    return s.program == like.program && s.stage == like.stage;
  });
  return found == gpu.shaders.end() ? nullptr : &*found;
}

std::string place(const std::string& gpu, const ShaderStatistics& s) {
  return fmt::format("{} {} on {}", s.program, s.stage, gpu);
}

void compare(const GpuStatistics& before, const GpuStatistics& now,
             std::vector<std::string>& found) {
  for (const ShaderStatistics& s : now.shaders) {
    const ShaderStatistics* old = find(before, s);
    if (!old) {
      found.push_back(place(now.gpu, s) + ": not in the baseline");
      continue;
    }
    for (const Number& n : kNumbers)
      if (worse(n.wanted, old->*n.member, s.*n.member))
        found.push_back(fmt::format("{}: {} {}, baseline {}", place(now.gpu, s), n.key, s.*n.member,
                                    old->*n.member));
  }
  for (const ShaderStatistics& s : before.shaders)
    if (!find(now, s)) found.push_back(place(now.gpu, s) + ": only in the baseline");
}

ordered_json numbers_of(const ShaderStatistics& s) {
  ordered_json numbers;
  for (const Number& n : kNumbers) numbers[n.key] = s.*n.member;
  return numbers;
}

Expected<ShaderStatistics> shader_from(const std::string& name, const ordered_json& numbers,
                                       const std::string& file) {
  const std::size_t space = name.find(' ');
  if (space == std::string::npos) return fail(file, name, "\"PROGRAM STAGE\" was expected");
  ShaderStatistics s{.program = name.substr(0, space), .stage = name.substr(space + 1)};
  for (const Number& n : kNumbers) {
    const auto value = numbers.find(n.key);
    if (value == numbers.end() || !value->is_number_integer())
      return fail(file, name + "." + n.key, "a whole number was expected");
    s.*n.member = value->get<int>();
  }
  return s;
}

std::string release(const GpuStatistics& gpu) { return gpu.mesa.substr(0, gpu.mesa.find('-')); }

}  // namespace

std::string to_json(std::span<const GpuStatistics> gpus) {
  std::string text =
      fmt::format("{{\n \"mesa\": {},\n \"gpus\": {{", ordered_json(gpus.front().mesa).dump());
  const char* next_gpu = "";
  for (const GpuStatistics& gpu : gpus) {
    text += fmt::format("{}\n  \"{}\": {{", next_gpu, gpu.gpu);
    const char* next = "";
    for (const ShaderStatistics& s : gpu.shaders) {
      text += fmt::format("{}\n   \"{} {}\": {}", next, s.program, s.stage, numbers_of(s).dump());
      next = ",";
    }
    text += "\n  }";
    next_gpu = ",";
  }
  return text + "\n }\n}\n";
}

Expected<std::vector<GpuStatistics>> from_json(const std::string& text, const std::string& file) {
  const auto json = ordered_json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("mesa") || !json["mesa"].is_string() ||
      !json.contains("gpus") || !json["gpus"].is_object()) {
    return fail(file, "", "an object with \"mesa\" and \"gpus\" was expected");
  }
  std::vector<GpuStatistics> gpus;
  for (const auto& [gpu, shaders] : json["gpus"].items()) {
    if (!shaders.is_object()) return fail(file, gpu, "an object was expected");
    gpus.push_back({gpu, json["mesa"].get<std::string>(), {}});
    for (const auto& [name, numbers] : shaders.items()) {
      auto shader = shader_from(name, numbers, file);
      if (!shader) return std::unexpected(shader.error());
      gpus.back().shaders.push_back(std::move(*shader));
    }
  }
  if (gpus.empty()) return fail(file, "gpus", "at least one was expected");
  return gpus;
}

std::vector<std::string> regressions(std::span<const GpuStatistics> baseline,
                                     std::span<const GpuStatistics> now) {
  std::vector<std::string> found;
  for (const GpuStatistics& gpu : now) {
    const auto before = std::ranges::find(baseline, gpu.gpu, &GpuStatistics::gpu);
    if (before == baseline.end()) {
      found.push_back(gpu.gpu + ": not in the baseline");
    } else {
      compare(*before, gpu, found);
    }
  }
  return found;
}

bool same_compiler(const GpuStatistics& a, const GpuStatistics& b) {
  return release(a) == release(b);
}

}  // namespace fluxgs::adreno
