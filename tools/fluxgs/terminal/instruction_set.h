// The instruction set that the environment asks for.
#pragma once

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// Fails where FLUXGS_ISA names one that this processor does not have: what was to be compared
/// would be another.
Expected<void> check_instruction_set();

}  // namespace fluxgs::cli
