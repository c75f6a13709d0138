#pragma once

#include <cstddef>

namespace fluxgs::cli {

/// The most memory that this program has held, in bytes; 0 where the system does not tell.
std::size_t peak_memory();

}  // namespace fluxgs::cli
