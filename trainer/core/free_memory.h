// Memory that programs may still take.
#pragma once

#include <cstdint>
#include <optional>

namespace fluxgs {

/// Bytes that the system can give without taking from other programs, by its own estimate
/// (MemAvailable of /proc/meminfo); nothing where it does not say.
std::optional<std::uint64_t> available_memory();

}  // namespace fluxgs
