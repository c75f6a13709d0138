#include "gl/quirks.h"

namespace fluxgs::gl {

std::vector<std::string> Quirks::names() const {
  std::vector<std::string> set;
  if (half_float_blending_truncates) set.emplace_back("half_float_blending_truncates");
  return set;
}

Quirks find_quirks(const Capabilities& capabilities) {
  Quirks quirks;
  quirks.half_float_blending_truncates = capabilities.renderer.starts_with("llvmpipe");
  return quirks;
}

}  // namespace fluxgs::gl
