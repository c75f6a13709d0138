// Capabilities of the driver, queried once after the context was made.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "fluxgs/error.h"

namespace fluxgs::gl {

struct Api;

/// False where no driver has compute shaders (WebGL), so that what needs them is not linked.
#ifdef FLUXGS_WITHOUT_COMPUTE
inline constexpr bool kMayCompute = false;
#else
inline constexpr bool kMayCompute = true;
#endif

struct Capabilities {
  std::string vendor, renderer, version;
  std::set<std::string> extensions;
  bool is_es = true;                ///< an ES context; otherwise desktop GL with shaders of ES 3.1
  int major = 0, minor = 0;         ///< of the context's version
  bool compute = true;              ///< compute shaders and storage buffers (ES 3.1)
  bool half_float_targets = false;  ///< RGBA16F can be rendered to and blended
  bool float_targets = false;       ///< RGBA32F can be rendered to and blended (EXT_float_blend)
  bool framebuffer_fetch = false;   ///< shaders read the pixel (EXT_shader_framebuffer_fetch)
  bool timestamps = false;          ///< glQueryCounter (EXT_disjoint_timer_query), with a clock
  bool debug = false;               ///< KHR_debug
  bool reset_notification = false;  ///< the context was made to say when the GPU was reset

  std::int64_t max_storage_block_bytes = 0;
  int max_compute_storage_blocks = 0, max_vertex_storage_blocks = 0;
  int max_work_group_invocations = 0, max_work_groups_x = 0;
  int max_shared_memory_bytes = 0;
  int max_texture_size = 0;
  int max_viewport_width = 0, max_viewport_height = 0;
};

/// Fails if the context is older than ES 3.0, or a desktop one without ARB_ES3_1_compatibility.
Expected<Capabilities> query_capabilities(Api& api);

/// Fails, naming the limit, where a driver with compute shaders offers less than the renderer
/// needs.
Expected<void> check_limits(const Capabilities& capabilities);

}  // namespace fluxgs::gl
