#include "tools/fluxgs/options/method_options.h"

#include <algorithm>
#include <memory>
#include <regex>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "trainer/train/schedule.h"

namespace fluxgs::cli {
namespace {

constexpr std::string_view kCommon[] = {"iterations", "seed",  "max-splats", "target-splats",
                                        "max-memory", "masks", "antialias"};

OptionField* find(OptionFields& fields, std::string_view name) {
  const auto at =
      std::ranges::find_if(fields, [&](const OptionField& f) { return name == f.name; });
  return at == fields.end() ? nullptr : &*at;
}

/// Refuses values that the option does not take.
void check(const std::string& name, const std::string& text) {
  TrainOptions scratch = default_options();
  OptionFields fields = scratch.fields();
  if (auto ok = set(*find(fields, name), text); !ok)
    throw CLI::ValidationError("--" + name, ok.error().what);
}

const char* type_name(const OptionField& f) {
  if (std::holds_alternative<int*>(f.value) || std::holds_alternative<std::uint64_t*>(f.value))
    return "INT";
  return std::holds_alternative<double*>(f.value) ? "FLOAT" : "";
}

std::string help_of(const OptionField& f) {
  const auto* choice = std::get_if<OptionChoice>(&f.value);
  if (std::holds_alternative<bool*>(f.value)) return fmt::format("{}: on or off", f.help);
  return choice ? fmt::format("{} {{{}}}", f.help, fmt::join(choice->names, ",")) : f.help;
}

/// Leaves groups out of the short help.
class ShortHelp final : public CLI::Formatter {
 public:
  explicit ShortHelp(std::vector<std::string> groups) : groups_(std::move(groups)) {}

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    shows_all_ = mode == CLI::AppFormatMode::All;
    // Groups that are left out leave their empty lines behind
    return std::regex_replace(Formatter::make_help(app, std::move(name), mode),
                              std::regex("\n{3,}"), "\n\n");
  }
  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    const bool shown = shows_all_ || is_positional || std::ranges::count(groups_, group) > 0;
    return shown ? Formatter::make_group(std::move(group), is_positional, std::move(options)) : "";
  }

 private:
  std::vector<std::string> groups_;
  mutable bool shows_all_ = false;
};

}  // namespace

void show_groups(CLI::App& command, std::vector<std::string> groups) {
  command.set_help_all_flag("--help-all", "print all options, by the phase of the training");
  for (const char* name : {"--help", "--help-all"}) command.get_option(name)->group("Help");
  groups.emplace_back("Help");
  const auto formatter = std::make_shared<ShortHelp>(std::move(groups));
  formatter->column_width(34);
  command.formatter(formatter);
}

void add_method_options(CLI::App& command, MethodOptions& given) {
  TrainOptions defaults = preset(preset_names().front()).value();
  for (const OptionField& f : defaults.fields()) {
    const std::string name = f.name;
    command
        .add_option_function<std::string>(
            "--" + name,
            [name, &given](const std::string& value) {
              check(name, value);
              given.emplace_back(name, value);
            },
            help_of(f))
        ->type_name(type_name(f))
        ->default_str(text_of(f))
        ->group(std::ranges::count(kCommon, name) > 0 ? kCommonOptions : std::string(f.group));
  }
}

std::vector<std::string> with_switches_on(std::vector<std::string> words) {
  TrainOptions defaults = default_options();
  std::vector<std::string> switches;
  for (const OptionField& f : defaults.fields())
    if (std::holds_alternative<bool*>(f.value)) switches.push_back(fmt::format("--{}", f.name));
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool has_value = i + 1 < words.size() && (words[i + 1] == "on" || words[i + 1] == "off");
    if (!has_value && std::ranges::count(switches, words[i]) > 0) words[i] += "=on";
  }
  return words;
}

MethodOptions changed_options(const MethodOptions& given, const TrainOptions& options) {
  TrainOptions before = options, after = options;
  apply(given, after);
  OptionFields fields = before.fields(), others = after.fields();
  MethodOptions changed;
  for (std::size_t i = 0; i < fields.size(); ++i)
    if (text_of(fields[i]) != text_of(others[i]))
      changed.emplace_back(fields[i].name, text_of(fields[i]));
  return changed;
}

void apply(const MethodOptions& given, TrainOptions& options) {
  OptionFields fields = options.fields();
  for (const auto& [name, text] : given) (void)set(*find(fields, name), text);
}

}  // namespace fluxgs::cli
