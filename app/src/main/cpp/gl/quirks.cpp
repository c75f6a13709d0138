#include "gl/quirks.h"

namespace fluxgs::gl {

std::vector<std::string> Quirks::names() const {
  std::vector<std::string> set;
  if (half_float_blending_truncates) set.emplace_back("half_float_blending_truncates");
  if (runs_on_cpu) set.emplace_back("runs_on_cpu");
  if (timer_queries_crash) set.emplace_back("timer_queries_crash");
  if (tiles) set.emplace_back("tiles");
  if (gpu_sort_fails) set.emplace_back("gpu_sort_fails");
  if (fragment_projection_fails) set.emplace_back("fragment_projection_fails");
  return set;
}

Quirks find_quirks(const Capabilities& capabilities) {
  Quirks quirks;
  for (const char* family : {"Adreno", "Mali", "Immortalis", "PowerVR", "Xclipse", "Maleoon"})
    quirks.tiles = quirks.tiles || capabilities.renderer.contains(family);
  quirks.half_float_blending_truncates = capabilities.renderer.contains("llvmpipe");
  quirks.runs_on_cpu = capabilities.renderer.contains("llvmpipe") ||
                       capabilities.renderer.contains("SwiftShader") ||
                       capabilities.renderer.contains("softpipe");
  quirks.timer_queries_crash =
      capabilities.renderer.contains("Mali") || capabilities.renderer.contains("Immortalis");
  return quirks;
}

}  // namespace fluxgs::gl
