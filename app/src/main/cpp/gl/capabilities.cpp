#include "gl/capabilities.h"

#include <algorithm>
#include <cstring>
#include <set>
#include <string_view>

#include "gl/api.h"
#include "gl/expected_chain.h"

namespace fluxgs::gl {
namespace {

std::string text(Api& api, GLenum name) {
  const GLubyte* bytes = api.GetString(name);
  return bytes ? reinterpret_cast<const char*>(bytes) : "";
}

int integer(Api& api, GLenum name) {
  GLint value = 0;
  api.GetIntegerv(name, &value);
  return value;
}

std::set<std::string> extensions(Api& api) {
  std::set<std::string> names;
  const int count = integer(api, GL_NUM_EXTENSIONS);
  for (int i = 0; i < count; ++i) {
    const GLubyte* name = api.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
    if (name) names.insert(reinterpret_cast<const char*>(name));
  }
  return names;
}

void ask_compute_limits(Api& api, Capabilities& c) {
  GLint64 bytes = 0;
  api.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
  c.max_storage_block_bytes = bytes;
  c.max_compute_storage_blocks = integer(api, GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
  c.max_vertex_storage_blocks = integer(api, GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS);
  c.max_work_group_invocations = integer(api, GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);
  api.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &c.max_work_groups_x);
  c.max_shared_memory_bytes = integer(api, GL_MAX_COMPUTE_SHARED_MEMORY_SIZE);
}

void ask_limits(Api& api, Capabilities& c) {
  if (c.compute) ask_compute_limits(api, c);
  c.max_texture_size = integer(api, GL_MAX_TEXTURE_SIZE);
  GLint viewport[2] = {};
  api.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  c.max_viewport_width = viewport[0];
  c.max_viewport_height = viewport[1];
}

// Without, glGetGraphicsResetStatus returns GL_NO_ERROR for ever (KHR_robustness).
bool notifies_of_resets(Api& api) {
  return integer(api, GL_RESET_NOTIFICATION_STRATEGY_KHR) == GL_LOSE_CONTEXT_ON_RESET_KHR;
}

void ask_extensions(Api& api, Capabilities& c) {
  c.extensions = extensions(api);
  const std::set<std::string>& has = c.extensions;
  if (!c.is_es) {  // All of it is core in desktop GL 4.5
    c.half_float_targets = c.float_targets = c.timestamps = c.debug = true;
    c.reset_notification = notifies_of_resets(api);
    return;
  }
  const bool float_buffers = has.contains("GL_EXT_color_buffer_float");
  c.half_float_targets = float_buffers || has.contains("GL_EXT_color_buffer_half_float");
  c.float_targets = float_buffers && has.contains("GL_EXT_float_blend");
  c.framebuffer_fetch = has.contains("GL_EXT_shader_framebuffer_fetch");
  c.timestamps = has.contains("GL_EXT_disjoint_timer_query");
  c.debug = has.contains("GL_KHR_debug");
  c.reset_notification = (has.contains("GL_KHR_robustness") || has.contains("GL_EXT_robustness")) &&
                         notifies_of_resets(api);
}

}  // namespace

Expected<Capabilities> query_capabilities(Api& api) {
  Capabilities c;
  c.vendor = text(api, GL_VENDOR);
  c.renderer = text(api, GL_RENDERER);
  c.version = text(api, GL_VERSION);
  c.is_es = c.version.starts_with("OpenGL ES");
  c.major = integer(api, GL_MAJOR_VERSION);
  c.minor = integer(api, GL_MINOR_VERSION);

  const auto at_least = [&](int major, int minor) {
    return c.major > major || (c.major == major && c.minor >= minor);
  };
  const bool enough =
      c.is_es ? at_least(3, 0)
              : at_least(4, 5) && extensions(api).contains("GL_ARB_ES3_1_compatibility");
  if (!enough) {
    return fail(
        c.renderer, "GL_VERSION",
        "OpenGL ES 3.0 or desktop OpenGL 4.5 is needed; the driver offers \"" + c.version + "\"");
  }
  c.compute = kMayCompute && (!c.is_es || at_least(3, 1));
  ask_limits(api, c);
  ask_extensions(api, c);
  return c;
}

Expected<void> check_limits(const Capabilities& c) {
  if (!c.compute) return {};
  const auto need = [&](const char* name, std::int64_t have,
                        std::int64_t wanted) -> Expected<void> {
    if (have >= wanted) return {};
    return fail(c.renderer, name,
                "the renderer needs " + std::to_string(wanted) + ", the driver offers " +
                    std::to_string(have));
  };
  // ES 3.1's own minimums (table 20.45): a driver with less is not one of ES 3.1. Storage blocks in
  // the vertex stage are optional there, and here (render/ordered_splats.h).
  return chain(
      [&] {
        return need("GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS", c.max_work_group_invocations, 128);
      },
      [&] { return need("GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS", c.max_compute_storage_blocks, 4); },
      [&] { return need("GL_MAX_COMPUTE_SHARED_MEMORY_SIZE", c.max_shared_memory_bytes, 16384); });
}

}  // namespace fluxgs::gl
