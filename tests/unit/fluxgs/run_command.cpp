#include "run_command.h"

namespace fluxgs::test {

const char* const kFluxgs = FLUXGS_BINARY;

}  // namespace fluxgs::test
