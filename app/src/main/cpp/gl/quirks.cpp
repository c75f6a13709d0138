#include "gl/quirks.h"
namespace fluxgs::gl {
Quirks find_quirks(const Capabilities&) { return {}; }
}  // namespace fluxgs::gl
