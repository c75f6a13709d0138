// Instruction sets that the kernels were compiled for and this machine runs.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace fluxgs {

enum class Isa { baseline, avx2, avx512 };

std::string_view name_of(Isa isa);

/// Compiled in and supported by this processor, slowest first; never empty.
std::vector<Isa> available_isas();

/// The fastest available one, unless the environment variable FLUXGS_ISA names another
/// (baseline, avx2, avx512). Asked once.
Isa best_isa();

}  // namespace fluxgs
