// fluxgs: the one desktop command.
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <regex>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "fluxgs/sanitize.h"
#include "tools/fluxgs/commands/command.h"
#include "tools/fluxgs/terminal/console.h"
#include "tools/fluxgs/terminal/instruction_set.h"
#include "tools/fluxgs/terminal/nearest_name.h"
#include "tools/fluxgs/terminal/run_lock.h"

namespace {

int report(const fluxgs::Error& error) {
  fluxgs::cli::say(
      fmt::format("fluxgs: error: {}\n", fluxgs::one_line(error.message(), std::string::npos)));
  return 1;
}

/// The sub-command that was parsed, or the program itself.
const CLI::App& parsed_command(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : parsed_command(*chosen.front());
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> names_of_commands(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

/// "--background: expected 3 values with commas between them, 1 given", or of an option that has
/// one value "--iterations: given 2 times, expected once"
std::string wrong_number_of_values(const std::string& text) {
  static const std::regex pattern("(--[a-z-]+): .*?([0-9]+) required but received ([0-9]+)");
  std::smatch parts;
  if (!std::regex_match(text, parts, pattern)) return text;
  if (parts[2] == "1")
    return fmt::format("{}: given {} times, expected once", parts[1].str(), parts[3].str());
  return fmt::format("{}: expected {} values with commas between them, {} given", parts[1].str(),
                     parts[2].str(), parts[3].str());
}

/// "unknown option --iteratoins; did you mean --iterations?", or what CLI11 says of other errors.
std::string usage_error(const CLI::App& app, const CLI::Error& error,
                        const std::vector<std::string>& arguments) {
  const auto kind = static_cast<CLI::ExitCodes>(error.get_exit_code());
  if (kind != CLI::ExitCodes::ExtrasError && kind != CLI::ExitCodes::RequiredError)
    return wrong_number_of_values(error.what());
  const CLI::App& command = parsed_command(app);
  const std::vector<std::string> words = command.remaining(), subs = names_of_commands(command);
  if (words.empty())
    return subs.empty() ? error.what()
                        : fmt::format("expected a sub-command: {}", fmt::join(subs, ", "));
  // A misspelled option leaves its value behind, too
  const auto option = std::ranges::find_if(words, [](auto& w) { return w.starts_with('-'); });
  const std::string& odd = option == words.end() ? words.front() : *option;
  const std::string word = odd.substr(0, odd.find('='));
  const bool is_option = word.starts_with('-');
  const char* what = is_option ? "option" : subs.empty() ? "argument" : "sub-command";
  if (const auto name = fluxgs::cli::switch_before(arguments, word); !is_option && !name.empty())
    return fmt::format("unknown argument {}; {} takes on or off", word, name);
  const std::string nearest =
      fluxgs::cli::nearest_name(word, is_option ? names_of_options(command) : subs);
  return fmt::format("unknown {} {}{}", what, word,
                     nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest));
}

/// Ends at once, but not without a word. Training takes the signal over to save first.
void say_interrupted(int signal) {
  constexpr char line[] = "\nfluxgs: interrupted\n";
  fluxgs::cli::remove_held_lock();
  if (::write(STDERR_FILENO, line, sizeof line - 1) < 0) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

int main(int argc, char** argv) {
  fluxgs::cli::guard_standard_streams();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(signal, say_interrupted) == SIG_IGN) std::signal(signal, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on file sizes shall be an error, not a death
  // Results belong to standard output, everything else to standard error.
  spdlog::set_default_logger(spdlog::stderr_logger_st("fluxgs"));
  spdlog::set_pattern("%v");

  CLI::App app("Train 3D Gaussian Splatting scenes from posed images and look at them.", "fluxgs");
  app.require_subcommand(1);
  app.set_version_flag("--version", FLUXGS_VERSION);
  const auto arguments = fluxgs::cli::plain_words({argv + std::min(argc, 1), argv + argc});
  app.failure_message([&](const CLI::App* program, const CLI::Error& error) {
    return fmt::format("fluxgs: error: {} (see --help)\n", usage_error(*program, error, arguments));
  });
  app.footer("Example: fluxgs train captures/garden -o garden.glb");
  fluxgs::cli::Action action;
  fluxgs::cli::add_train(app, action);
  fluxgs::cli::add_eval(app, action);
  fluxgs::cli::add_render(app, action);
  fluxgs::cli::add_view(app, action);
  fluxgs::cli::add_bench(app, action);
  fluxgs::cli::add_convert(app, action);
  fluxgs::cli::add_info(app, action);
  fluxgs::cli::add_report(app, action);
  fluxgs::cli::add_web(app, action);
  fluxgs::cli::add_doctor(app, action);

  const std::vector<std::string> commands = names_of_commands(app);
  if (argc > 2 && std::string(argv[1]) == "help" && argv[2][0] != '-' &&
      std::ranges::count(commands, argv[2]) == 0) {
    const std::string nearest = fluxgs::cli::nearest_name(argv[2], commands);
    report({"", "",
            fmt::format("unknown sub-command {}{}", argv[2],
                        nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest))});
    return 2;
  }
  try {
    app.parse(std::vector(arguments.rbegin(), arguments.rend()));  // CLI11 takes the last one first
  } catch (const CLI::ParseError& e) {
    if (app.exit(e) != 0) return 2;
    const auto printed = fluxgs::cli::flush_standard_output();
    return printed ? 0 : report(printed.error());
  }
  try {
    fluxgs::Expected<void> done = fluxgs::cli::check_instruction_set();
    if (done) done = action();
    if (done) done = fluxgs::cli::flush_standard_output();
    return done ? 0 : report(done.error());
  } catch (const std::bad_alloc&) {
    return report(
        {"", "",
         "not enough memory; smaller images, a larger --downscale or fewer splats need less"});
  } catch (const std::system_error& e) {
    if (std::string(e.what()).starts_with("cannot write to file"))  // fmt::print()
      return report({"standard output", "", "cannot be written: " + e.code().message()});
    return report({"", "",
                   e.code() == std::errc::resource_unavailable_try_again
                       ? "cannot start a thread: too many threads or too little memory; "
                         "try --threads 1"
                       : e.what()});
  } catch (const std::exception& e) {
    return report({"", "", e.what()});
  }
}
