// Known defects of drivers, each a named boolean with the reason beside it. Code that works around
// one asks for the name, never for the driver.
#pragma once

#include "gl/capabilities.h"

namespace fluxgs::gl {

struct Quirks {};

Quirks find_quirks(const Capabilities& capabilities);

}  // namespace fluxgs::gl
