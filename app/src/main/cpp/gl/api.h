// OpenGL ES as a table of functions that the platform's getProcAddress filled. Nothing here is
// linked against GL, so that one program can talk to several implementations (EGL, OSMesa, ANGLE).
#pragma once

#include <functional>
#include <memory>

// clang-format off
#include <GLES3/gl31.h>   // before the extensions: it declares the types they use
#include <GLES2/gl2ext.h>
// clang-format on

#include "fluxgs/error.h"
#include "gl/capabilities.h"
#include "gl/debug_log.h"
#include "gl/quirks.h"

// Every function that the renderer, and whoever times it, calls: those of ES 3.0 that WebGL 2 has
// and those that it lacks, and what ES 3.1 adds for compute shaders (Capabilities::compute).
// Desktop GL 4.5 has them all.
// clang-format off
#define FLUXGS_GL_WEB_FUNCTIONS(X) \
  X(ActiveTexture) X(AttachShader) X(BeginQuery) X(BindBuffer) X(BindBufferBase) \
  X(BindFramebuffer) X(BindTexture) X(BindVertexArray) X(BlendFuncSeparate) X(BlitFramebuffer) \
  X(BufferData) X(BufferSubData) X(CheckFramebufferStatus) X(ClearBufferfv) X(ClientWaitSync) X(ColorMask) \
  X(CompileShader) X(CopyBufferSubData) X(CreateProgram) X(CreateShader) X(DeleteBuffers) \
  X(DeleteFramebuffers) X(DeleteProgram) X(DeleteQueries) X(DeleteShader) X(DeleteSync) \
  X(DeleteTextures) X(DeleteVertexArrays) X(DepthFunc) X(DepthMask) X(Disable) \
  X(DrawArrays) X(DrawBuffers) X(DrawElementsInstanced) X(Enable) X(EndQuery) \
  X(FenceSync) X(Finish) X(FramebufferTexture2D) X(GenBuffers) X(GenFramebuffers) X(GenQueries) \
  X(GenTextures) X(GenVertexArrays) X(GetError) X(GetInteger64v) X(GetIntegeri_v) X(GetIntegerv) \
  X(GetProgramInfoLog) X(GetProgramiv) X(GetShaderInfoLog) X(GetShaderiv) X(GetString) \
  X(GetStringi) X(GetUniformBlockIndex) X(GetUniformLocation) X(InvalidateFramebuffer) X(LinkProgram) \
  X(PixelStorei) X(ReadBuffer) X(ReadPixels) X(Scissor) X(ShaderSource) X(TexParameteri) X(TexStorage2D) \
  X(TexSubImage2D) X(Uniform1f) X(Uniform1i) X(Uniform1ui) X(Uniform2f) X(Uniform3f) X(UniformBlockBinding) \
  X(UseProgram) X(Viewport)
#define FLUXGS_GL_MAPPING_FUNCTIONS(X) X(MapBufferRange) X(UnmapBuffer)
#define FLUXGS_GL_FUNCTIONS(X) FLUXGS_GL_WEB_FUNCTIONS(X) FLUXGS_GL_MAPPING_FUNCTIONS(X)
#define FLUXGS_GL_COMPUTE_FUNCTIONS(X) \
  X(BindImageTexture) X(DispatchCompute) X(DispatchComputeIndirect) X(DrawElementsIndirect) X(MemoryBarrier)
// clang-format on

namespace fluxgs::gl {

/// The functions of one context and what is known about it. Every function must be called on the
/// thread on which that context is current. Neither copied nor moved: the driver holds a pointer
/// to `debug`.
struct Api {
// NOLINTNEXTLINE(bugprone-macro-parentheses): it is a name, not an expression
#define FLUXGS_GL_MEMBER(name) decltype(&::gl##name) name = nullptr;
  FLUXGS_GL_FUNCTIONS(FLUXGS_GL_MEMBER)
  FLUXGS_GL_COMPUTE_FUNCTIONS(FLUXGS_GL_MEMBER)  // null where Capabilities::compute is false
#undef FLUXGS_GL_MEMBER

  // Extensions: null where the driver has none.
  PFNGLQUERYCOUNTEREXTPROC QueryCounter = nullptr;
  PFNGLGETQUERYOBJECTUI64VEXTPROC GetQueryObjectui64v = nullptr;
  PFNGLGETQUERYIVEXTPROC GetQueryiv = nullptr;
  PFNGLDEBUGMESSAGECALLBACKKHRPROC DebugMessageCallback = nullptr;
  PFNGLGETGRAPHICSRESETSTATUSKHRPROC GetGraphicsResetStatus = nullptr;

  Capabilities capabilities;
  Quirks quirks;
  DebugLog debug;
  /// An error was GL_OUT_OF_MEMORY. Stays until whoever has made room resets it.
  bool out_of_memory = false;
  /// The context is gone for good and its objects with it: see context_lost().
  bool lost = false;

  Api() = default;
  Api(const Api&) = delete;
  Api& operator=(const Api&) = delete;
};

/// Returns the address of the GL function of that name ("gl…"), or null.
using ProcLoader = std::function<void*(const char* name)>;

/// Fills the table for the context that is current on this thread and asks the driver for its
/// capabilities. Fails if a function is missing or the context is older than ES 3.0 (or desktop GL
/// 4.5 with ARB_ES3_1_compatibility).
Expected<std::unique_ptr<Api>> load_api(const ProcLoader& loader);

/// glMemoryBarrier, for stores of shaders; nothing where no shader can store.
void memory_barrier(Api& api, GLbitfield barriers);

/// Takes all pending errors of the context, and notes down in `api` what they say of it. Returns
/// the first, or GL_NO_ERROR.
GLenum clear_errors(Api& api);

/// Fails with `where` and the error's name if a GL error is pending.
Expected<void> check_errors(Api& api, const char* where);

/// True if the context was lost: the GPU was reset, or the system took it away. Asks the driver,
/// through KHR_robustness or else, taking them, its errors, and remembers. Then every object has to
/// be made again in a new context; the owners of the old ones may go at any time, as nothing is
/// deleted any more.
bool context_lost(Api& api);

}  // namespace fluxgs::gl
