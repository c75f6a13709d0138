// Memory that the machine, and who started the program, have left for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace fluxgs {

/// Bytes that programs can still take without others being swapped out: of the machine
/// (MemAvailable), of the control groups that the process is in (containers, systemd) and of the
/// limit to its address space (ulimit -v), the least. Nothing where none is known.
std::optional<std::uint64_t> available_memory();

/// Bytes that the control groups (version 2 or 1) leave; nothing where they set no limit. `groups`
/// is the content of /proc/self/cgroup, `root` the folder that is /sys/fs/cgroup.
std::optional<std::uint64_t> available_in_groups(const std::string& groups,
                                                 const std::filesystem::path& root);

}  // namespace fluxgs
