#include "trainer/core/free_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <string_view>

namespace fluxgs {
namespace {

namespace fs = std::filesystem;
using Bytes = std::optional<std::uint64_t>;

/// The number that a file holds; nothing for "max".
Bytes number_in(const fs::path& file) {
  std::ifstream in(file);
  std::uint64_t number = 0;
  return in >> number ? Bytes(number) : std::nullopt;
}

/// The number behind a name in lines of "name number".
Bytes named_in(const fs::path& file, std::string_view name) {
  std::ifstream in(file);
  std::string word, rest;
  std::uint64_t number = 0;
  while (in >> word >> number) {
    if (word == name) return number;
    std::getline(in, rest);
  }
  return std::nullopt;
}

/// True if one of the words between commas is that one.
bool lists(const std::string& words, std::string_view word) {
  std::istringstream in(words);
  for (std::string one; std::getline(in, one, ',');)
    if (one == word) return true;
  return false;
}

Bytes least(const Bytes& a, const Bytes& b) { return a && b ? std::min(*a, *b) : (a ? a : b); }

/// Names of a group's files: its limit, what it takes, and what of that are cached files.
struct GroupFiles {
  const char *limit, *taken, *cached;
};

/// The least that a group, or one of those around it up to `root`, leaves.
Bytes left_in(const fs::path& root, const fs::path& group, const GroupFiles& files) {
  Bytes left;
  for (fs::path inside = group.relative_path();; inside = inside.parent_path()) {
    const fs::path folder = root / inside;
    const Bytes limit = number_in(folder / files.limit), taken = number_in(folder / files.taken);
    if (limit && taken) {
      const std::uint64_t cached = named_in(folder / "memory.stat", files.cached).value_or(0);
      const std::uint64_t held = *taken - std::min(*taken, cached);
      left = least(left, *limit - std::min(*limit, held));
    }
    if (inside.empty()) return left;
  }
}

/// Bytes that the limit to the address space leaves.
Bytes left_of_addresses() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  const auto pages = number_in("/proc/self/statm");
  if (!pages) return std::nullopt;
  const std::uint64_t taken = *pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  const std::uint64_t all = limit.rlim_cur;
  return all - std::min(all, taken);
}

}  // namespace

std::optional<std::uint64_t> available_in_groups(const std::string& groups, const fs::path& root) {
  std::istringstream lines(groups);
  Bytes left;
  for (std::string line; std::getline(lines, line);) {
    // hierarchy:controllers:/path; version 2 has hierarchy 0 and no controllers (cgroups(7))
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == line.npos || second == line.npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty())
      left = least(left, left_in(root, group, {"memory.max", "memory.current", "inactive_file"}));
    else if (lists(controllers, "memory"))
      left = least(
          left, left_in(root / "memory", group,
                        {"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"}));
  }
  return left;
}

std::optional<std::uint64_t> available_memory() {
  constexpr std::uint64_t kKibibyte = 1024;
  Bytes machine = named_in("/proc/meminfo", "MemAvailable:");
  if (machine) *machine *= kKibibyte;
  std::ifstream in("/proc/self/cgroup");
  const std::string groups(std::istreambuf_iterator<char>(in), {});
  return least(least(machine, available_in_groups(groups, "/sys/fs/cgroup")), left_of_addresses());
}

}  // namespace fluxgs
