#include "tools/fluxgs/method_options.h"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace fluxgs::cli {
namespace {

/// CLI11 would take −1 for 2⁶⁴ − 1, and that for anything larger.
std::uint64_t parse_natural(const std::string& name, const std::string& text) {
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, status] = std::from_chars(text.data(), end, value);
  if (status != std::errc() || rest != end)
    throw CLI::ValidationError("--" + name, "expected a whole number from 0 to 2^64 - 1");
  return value;
}

void check_range(const OptionField& f, double value) {
  if (!(value >= f.low && value <= f.high))  // also refuses NaN
    throw CLI::ValidationError(std::string("--") + f.name,
                               fmt::format("expected {:.10g} to {:.10g}", f.low, f.high));
}

CLI::Option* add_number(CLI::App& command, const OptionField& f, MethodOptions& given) {
  const std::string name = std::string("--") + f.name;
  if (f.real)
    return command.add_option_function<double>(
        name,
        [&f, &given](double value) {
          check_range(f, value);
          given.push_back([&f, value](TrainOptions& o) { o.*f.real = value; });
        },
        f.help);
  if (f.integer)
    return command.add_option_function<std::int64_t>(
        name,
        [&f, &given](std::int64_t value) {
          check_range(f, static_cast<double>(value));
          given.push_back([&f, value](TrainOptions& o) { o.*f.integer = static_cast<int>(value); });
        },
        f.help);
  return command.add_option_function<std::string>(
      name,
      [&f, &given](const std::string& text) {
        const std::uint64_t value = parse_natural(f.name, text);
        given.push_back([&f, value](TrainOptions& o) { o.*f.natural = value; });
      },
      f.help);
}

CLI::Option* add_choice(CLI::App& command, const OptionField& f, MethodOptions& given) {
  const auto names = f.choice.names;
  return command
      .add_option_function<std::string>(
          std::string("--") + f.name,
          [&f, &given](const std::string& text) {
            const auto at = std::ranges::find(f.choice.names, text);
            const int value = static_cast<int>(at - f.choice.names.begin());
            given.push_back([&f, value](TrainOptions& o) { f.choice.set(o, value); });
          },
          f.help)
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
}

std::string shown(const OptionField& f, const TrainOptions& options) {
  if (f.real) return fmt::format("{:g}", options.*f.real);
  if (f.integer) return fmt::format("{}", options.*f.integer);
  if (f.natural) return fmt::format("{}", options.*f.natural);
  return std::string(f.choice.names[static_cast<std::size_t>(f.choice.get(options))]);
}

}  // namespace

void add_method_options(CLI::App& command, MethodOptions& given) {
  const TrainOptions defaults = preset(preset_names().front()).value();
  for (const OptionField& f : option_fields()) {
    CLI::Option* option =
        f.choice.get ? add_choice(command, f, given) : add_number(command, f, given);
    option->default_str(shown(f, defaults));
    const std::string_view name = f.name;
    const bool common =
        name == "iterations" || name == "max-splats" || name == "target-splats" || name == "seed";
    option->group(common ? "Options" : "Constants of the method");
  }
}

void apply(const MethodOptions& given, TrainOptions& options) {
  for (const auto& change : given) change(options);
}

}  // namespace fluxgs::cli
