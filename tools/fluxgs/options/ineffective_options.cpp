#include "tools/fluxgs/options/ineffective_options.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trainer/train/schedule.h"

namespace fluxgs::cli {
namespace {

/// Options with the same need, in the order of their first.
using ByNeed = std::vector<std::pair<std::string, std::vector<std::string>>>;

void add(ByNeed& all, const OptionField& field) {
  const auto known = std::ranges::find(all, field.needs, &ByNeed::value_type::first);
  auto& names = known == all.end()
                    ? all.emplace_back(field.needs, std::vector<std::string>()).second
                    : known->second;
  names.push_back(fmt::format("--{}", field.name));
}

/// Warning about a phase that does nothing within the run, or not as asked.
std::string warning_of(const Phase& phase, int iterations) {
  const Period period = phase.period();
  if (period.takes_place(iterations)) return phase.warning();
  if (period.from > iterations)
    return fmt::format("{} never takes place: it would begin at iteration {}, after the last, {}",
                       phase.name(), period.from, iterations);
  return fmt::format("{} never takes place: it would be due every {} iterations from {} to {}",
                     phase.name(), period.interval, period.from,
                     std::min(period.until, iterations));
}

bool same_words(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b,
                            [](char x, char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

std::vector<std::string> ineffective_options(const std::set<std::string>& given,
                                             const TrainOptions& options) {
  Schedule schedule = plan_schedule(options);
  ByNeed ineffective;
  std::set<std::string_view> groups;  // that something was given of
  for (const OptionField& field : schedule.options.fields()) {
    if (!given.contains(field.name)) continue;
    groups.insert(field.group);
    if (!field.needs.empty()) add(ineffective, field);
  }
  std::vector<std::string> lines;
  for (const auto& [needs, names] : ineffective)
    lines.push_back(fmt::format("{} {} no effect, expected {}", fmt::join(names, ", "),
                                names.size() == 1 ? "has" : "have", needs));
  // Who has not asked for a phase may want a short run
  for (const auto& phase : schedule.phases) {
    const auto asked = [&](std::string_view group) { return same_words(group, phase->name()); };
    if (!std::ranges::any_of(groups, asked)) continue;
    if (std::string line = warning_of(*phase, options.iterations); !line.empty())
      lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace fluxgs::cli
