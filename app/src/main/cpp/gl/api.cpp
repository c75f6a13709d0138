#include "gl/api.h"

#include <string>

namespace fluxgs::gl {
namespace {

template <class Function>
void load(Function& function, const ProcLoader& loader, const char* name) {
  function = reinterpret_cast<Function>(loader(name));
}

// Extension entry points carry a suffix on ES and none in desktop GL, where they are core.
template <class Function>
void load_extension(Function& function, const ProcLoader& loader, const char* name,
                    const char* suffix, bool is_es) {
  load(function, loader, (name + std::string(is_es ? suffix : "")).c_str());
}

std::string error_name(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "out of graphics memory";
    case GL_CONTEXT_LOST_KHR:
      return "the context was lost";
    default:
      return "GL error " + std::to_string(error);
  }
}

/// The names of those of the functions that the driver lacks.
std::string load_core(Api& api, const ProcLoader& loader) {
  std::string missing;
#define FLUXGS_GL_LOAD(name)          \
  load(api.name, loader, "gl" #name); \
  if (!api.name) missing += " gl" #name;
  FLUXGS_GL_FUNCTIONS(FLUXGS_GL_LOAD)
#undef FLUXGS_GL_LOAD
  return missing;
}

bool load_compute(Api& api, const ProcLoader& loader) {
  bool all = true;
#define FLUXGS_GL_LOAD(name)          \
  load(api.name, loader, "gl" #name); \
  all = all && api.name;
  FLUXGS_GL_COMPUTE_FUNCTIONS(FLUXGS_GL_LOAD)
#undef FLUXGS_GL_LOAD
  return all;
}

/// The extension allows a clock without digits: its times are all 0.
bool clock_counts(Api& api) {
  if (!api.QueryCounter || !api.GetQueryObjectui64v || !api.GetQueryiv) return false;
  GLint bits = 0;
  api.GetQueryiv(GL_TIMESTAMP_EXT, GL_QUERY_COUNTER_BITS_EXT, &bits);
  return bits > 0;
}

void load_extensions(Api& api, const ProcLoader& loader) {
  Capabilities& has = api.capabilities;
  has.timestamps = has.timestamps && !api.quirks.timer_queries_crash;
  if (has.timestamps) {
    load_extension(api.QueryCounter, loader, "glQueryCounter", "EXT", has.is_es);
    load_extension(api.GetQueryObjectui64v, loader, "glGetQueryObjectui64v", "EXT", has.is_es);
    load_extension(api.GetQueryiv, loader, "glGetQueryiv", "EXT", has.is_es);
    has.timestamps = clock_counts(api);
  }
  if (has.debug) {
    load_extension(api.DebugMessageCallback, loader, "glDebugMessageCallback", "KHR", has.is_es);
  }
  if (has.reset_notification) {
    load_extension(api.GetGraphicsResetStatus, loader, "glGetGraphicsResetStatus", "KHR",
                   has.is_es);
    if (!api.GetGraphicsResetStatus)
      load(api.GetGraphicsResetStatus, loader, "glGetGraphicsResetStatusEXT");
  }
}

}  // namespace

Expected<std::unique_ptr<Api>> load_api(const ProcLoader& loader) {
  auto api = std::make_unique<Api>();
  if (const std::string missing = load_core(*api, loader); !missing.empty())
    return fail("OpenGL", "functions", "missing:" + missing + "; OpenGL ES 3.0 is needed");
  auto capabilities = query_capabilities(*api);
  if (!capabilities) return std::unexpected(capabilities.error());
  api->capabilities = std::move(*capabilities);
  if (!load_compute(*api, loader)) api->capabilities.compute = false;
  api->quirks = find_quirks(api->capabilities);
  load_extensions(*api, loader);
  return api;
}

void memory_barrier(Api& api, GLbitfield barriers) {
  if (api.MemoryBarrier) api.MemoryBarrier(barriers);
}

GLenum clear_errors(Api& api) {
  GLenum first = GL_NO_ERROR;
  // Bounded: a lost context may report errors for ever
  for (int i = 0; i < 64 && !api.lost; ++i) {
    const GLenum error = api.GetError();
    if (error == GL_NO_ERROR) break;
    if (first == GL_NO_ERROR) first = error;
    api.out_of_memory = api.out_of_memory || error == GL_OUT_OF_MEMORY;
    api.lost = error == GL_CONTEXT_LOST_KHR;
  }
  return api.lost ? GL_CONTEXT_LOST_KHR : first;
}

Expected<void> check_errors(Api& api, const char* where) {
  const GLenum error = clear_errors(api);
  if (error == GL_NO_ERROR) return {};
  return fail("OpenGL", where, error_name(error));
}

bool context_lost(Api& api) {
  if (api.lost) return true;
  if (api.GetGraphicsResetStatus)
    api.lost = api.GetGraphicsResetStatus() != GL_NO_ERROR;
  else
    clear_errors(api);
  return api.lost;
}

}  // namespace fluxgs::gl
