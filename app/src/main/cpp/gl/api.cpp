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

Expected<void> load_core(Api& api, const ProcLoader& loader) {
  std::string missing;
#define FLUXGS_GL_LOAD(name)          \
  load(api.name, loader, "gl" #name); \
  if (!api.name) missing += " gl" #name;
  FLUXGS_GL_FUNCTIONS(FLUXGS_GL_LOAD)
#undef FLUXGS_GL_LOAD
  if (missing.empty()) return {};
  return fail("OpenGL", "functions", "missing:" + missing + "; OpenGL ES 3.1 is needed");
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
  if (auto loaded = load_core(*api, loader); !loaded) return std::unexpected(loaded.error());
  auto capabilities = query_capabilities(*api);
  if (!capabilities) return std::unexpected(capabilities.error());
  api->capabilities = std::move(*capabilities);
  api->quirks = find_quirks(api->capabilities);
  load_extensions(*api, loader);
  return api;
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
