// Stands between the renderer and the driver: a context that is lost at any call, a GPU with little
// memory, and the account of what is allocated.
#pragma once

#include <cstddef>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "gl/api.h"
#include "render/frame_uniforms.h"

namespace fluxgs::test {

/// Known defects of drivers, each played while it is set.
struct Defects {
  /// The element buffer does not belong to the vertex array (Mali, by Filament's list).
  bool forgets_element_buffer = false;
  bool fails_draws = false;  ///< indirect draws end in GL_INVALID_OPERATION
  /// The vertex stage reads zeros from storage buffers (Adreno 6xx and 7xx read garbage).
  bool loses_vertex_storage = false;
  bool loses_dispatches = false;       ///< every second indirect dispatch does nothing
  bool refuses_float_targets = false;  ///< though it lists them
  std::string unlinkable = {};         ///< programs with this text in a shader do not link
  bool slow = false;                   ///< no frame is finished yet, when asked
  bool wild_clock = false;             ///< of timer queries
  bool shifts_projection = false;      ///< the centre of a frame's camera is another
  bool coarse_fragments = false;       ///< project.frag computes centres with 8 bits
};

/// What the functions of the one Api under a GlFaults do.
struct FaultState {
  Defects defects;
  long calls = 0;              ///< so far
  long lost_after = -1;        ///< calls that still reach the driver; negative: all
  std::size_t memory = ~0UL;   ///< bytes that buffers and textures may take
  std::size_t used = 0;        ///< bytes they take
  std::size_t max_used = 0;    ///< the largest `used` so far
  long allocations = 0;        ///< so far
  long framebuffers = 0;       ///< there are
  GLenum error = GL_NO_ERROR;  ///< the next glGetError() says so
  long draws = 0;              ///< of splats
  long fences = 0;             ///< so far
  bool read_of_draw = false;   ///< a draw may still read what shaders write without a barrier
  long overwritten = 0;        ///< dispatches while that is so

  std::map<GLenum, GLuint> buffer_at, texture_at;    // bindings
  std::map<GLuint, GLuint> storage_at;               // buffers by binding
  std::map<GLuint, GLenum> formats;                  // of textures
  GLenum attached = 0;                               // the format of the last attachment
  std::map<GLuint, bool> bad_shaders, bad_programs;  // with the text of `unlinkable`
  long indirect_dispatches = 0;
  GLuint zeros = 0;                                 // a buffer of ours
  std::map<GLuint, std::size_t> buffers, textures;  // bytes of each

  bool is_lost() const { return lost_after >= 0 && calls > lost_after; }
  /// Whether there is room for so many bytes in the place of `old`.
  bool take(std::size_t bytes, std::size_t old);
};
inline FaultState faults;

/// Whether this thread is in a call of the driver that went through GlFaults.
inline thread_local bool inside_driver = false;

inline bool FaultState::take(std::size_t bytes, std::size_t old) {
  ++allocations;
  if (used - old + bytes > memory) {
    error = GL_OUT_OF_MEMORY;
    return false;
  }
  used += bytes - old;
  max_used = used > max_used ? used : max_used;
  return true;
}

template <auto Member>
inline std::remove_reference_t<decltype(std::declval<gl::Api&>().*Member)> driver = nullptr;

template <auto A, auto B>
inline constexpr bool kIs =
    std::is_same_v<std::integral_constant<decltype(A), A>, std::integral_constant<decltype(B), B>>;

inline std::size_t texel_bytes(GLenum format) {
  switch (format) {
    case GL_RGBA32F:
    case GL_RGBA32UI:
      return 16;
    case GL_RGBA16F:
    case GL_RG32UI:
      return 8;
    case GL_DEPTH_COMPONENT16:
      return 2;
    default:
      return 4;
  }
}

/// Binds a storage buffer of zeros, as large as the one that is there.
inline void bind_zeros(GLuint index) {
  const std::vector<std::byte> zeros(faults.buffers[faults.storage_at[index]]);
  if (faults.zeros == 0) driver<&gl::Api::GenBuffers>(1, &faults.zeros);
  driver<&gl::Api::BindBufferBase>(GL_SHADER_STORAGE_BUFFER, index, faults.zeros);
  driver<&gl::Api::BufferData>(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(zeros.size()),
                               zeros.data(), GL_DYNAMIC_COPY);
}

/// Changes the answer of a driver, after it was asked.
template <auto Member, class... A>
void after(A... arguments) {
  [[maybe_unused]] const auto all = std::make_tuple(arguments...);
  if constexpr (kIs<Member, &gl::Api::GetProgramiv>) {
    if (std::get<1>(all) == GL_LINK_STATUS && faults.bad_programs[std::get<0>(all)])
      *std::get<2>(all) = GL_FALSE;
  } else if constexpr (kIs<Member, &gl::Api::GetQueryObjectui64v>) {
    constexpr GLuint64 kOdd = 0x9E3779B97F4A7C15U;
    if (faults.defects.wild_clock) *std::get<2>(all) = kOdd * static_cast<GLuint64>(faults.calls);
  }
}

// What is done before, or instead of, the call of the driver. False: instead.
template <auto Member, class... A>
bool before(A... arguments) {
  [[maybe_unused]] const auto all = std::make_tuple(arguments...);
  if constexpr (kIs<Member, &gl::Api::BindBuffer>) {
    faults.buffer_at[std::get<0>(all)] = std::get<1>(all);
  } else if constexpr (kIs<Member, &gl::Api::BufferSubData>) {
    if (faults.defects.shifts_projection && std::get<2>(all) == sizeof(render::FrameUniforms)) {
      render::FrameUniforms moved;
      std::memcpy(&moved, std::get<3>(all), sizeof moved);
      moved.camera_centre[0] += 0.02F;
      driver<Member>(std::get<0>(all), std::get<1>(all), std::get<2>(all), &moved);
      return false;
    }
  } else if constexpr (kIs<Member, &gl::Api::BindTexture>) {
    faults.texture_at[std::get<0>(all)] = std::get<1>(all);
  } else if constexpr (kIs<Member, &gl::Api::BufferData>) {
    std::size_t& held = faults.buffers[faults.buffer_at[std::get<0>(all)]];
    const auto bytes = static_cast<std::size_t>(std::get<1>(all));
    if (!faults.take(bytes, held)) return false;
    held = bytes;
  } else if constexpr (kIs<Member, &gl::Api::TexStorage2D>) {
    std::size_t& held = faults.textures[faults.texture_at[std::get<0>(all)]];
    const std::size_t bytes = texel_bytes(std::get<2>(all)) *
                              static_cast<std::size_t>(std::get<3>(all)) *
                              static_cast<std::size_t>(std::get<4>(all));
    if (!faults.take(bytes, held)) return false;
    held = bytes;
    faults.formats[faults.texture_at[std::get<0>(all)]] = std::get<2>(all);
  } else if constexpr (kIs<Member, &gl::Api::FramebufferTexture2D>) {
    faults.attached = faults.formats[std::get<3>(all)];
  } else if constexpr (kIs<Member, &gl::Api::BindBufferBase>) {
    if (std::get<0>(all) == GL_SHADER_STORAGE_BUFFER)
      faults.storage_at[std::get<1>(all)] = std::get<2>(all);
  } else if constexpr (kIs<Member, &gl::Api::ShaderSource>) {
    std::string text;
    const auto strings = std::get<2>(all);
    const auto lengths = std::get<3>(all);
    for (GLsizei i = 0; i < std::get<1>(all); ++i)
      text += lengths ? std::string(strings[i], static_cast<std::size_t>(lengths[i]))
                      : std::string(strings[i]);
    const std::string& bad = faults.defects.unlinkable;
    faults.bad_shaders[std::get<0>(all)] = !bad.empty() && text.find(bad) != text.npos;
    constexpr std::string_view kExact = "(p.xy / p.z)";
    const std::size_t at = text.find(kExact);
    if (faults.defects.coarse_fragments && text.contains("a fragment is a splat") &&
        at != text.npos) {
      text.replace(at, kExact.size(), "(floor(256.0 * p.xy / p.z) / 256.0)");
      const char* changed = text.c_str();
      driver<Member>(std::get<0>(all), 1, &changed, nullptr);
      return false;
    }
  } else if constexpr (kIs<Member, &gl::Api::AttachShader>) {
    bool& bad = faults.bad_programs[std::get<0>(all)];
    bad = bad || faults.bad_shaders[std::get<1>(all)];
  } else if constexpr (kIs<Member, &gl::Api::DeleteProgram>) {
    faults.bad_programs.erase(std::get<0>(all));
  } else if constexpr (kIs<Member, &gl::Api::BindVertexArray>) {
    if (faults.defects.forgets_element_buffer && std::get<0>(all) != 0) {
      driver<Member>(arguments...);
      driver<&gl::Api::BindBuffer>(GL_ELEMENT_ARRAY_BUFFER, 0);
      return false;
    }
  } else if constexpr (kIs<Member, &gl::Api::DispatchComputeIndirect>) {
    if (faults.defects.loses_dispatches && ++faults.indirect_dispatches % 2 == 0) return false;
  } else if constexpr (kIs<Member, &gl::Api::GenFramebuffers>) {
    faults.framebuffers += std::get<0>(all);
  } else if constexpr (kIs<Member, &gl::Api::DeleteFramebuffers>) {
    faults.framebuffers -= std::get<0>(all);
  } else if constexpr (kIs<Member, &gl::Api::DrawElementsIndirect>) {
    ++faults.draws;
    faults.read_of_draw = true;
    if (faults.defects.fails_draws) {
      faults.error = GL_INVALID_OPERATION;
      return false;
    }
    if (faults.defects.loses_vertex_storage) bind_zeros(1);
  } else if constexpr (kIs<Member, &gl::Api::DrawElementsInstanced>) {
    ++faults.draws;
  } else if constexpr (kIs<Member, &gl::Api::MemoryBarrier>) {
    if ((std::get<0>(all) & GL_SHADER_STORAGE_BARRIER_BIT) != 0) faults.read_of_draw = false;
  } else if constexpr (kIs<Member, &gl::Api::DispatchCompute>) {
    faults.overwritten += faults.read_of_draw;
  } else if constexpr (kIs<Member, &gl::Api::DeleteBuffers> ||
                       kIs<Member, &gl::Api::DeleteTextures>) {
    auto& held = kIs<Member, &gl::Api::DeleteBuffers> ? faults.buffers : faults.textures;
    for (GLsizei i = 0; i < std::get<0>(all); ++i)
      if (const auto it = held.find(std::get<1>(all)[i]); it != held.end()) {
        faults.used -= it->second;
        held.erase(it);
      }
  }
  return true;
}

template <auto Member, class R, class... A>
R GL_APIENTRY through(A... arguments) {
  ++faults.calls;
  if (faults.is_lost()) {  // KHR_robustness: commands do nothing, and glGetError says why
    if constexpr (kIs<Member, &gl::Api::GetError>) return GL_CONTEXT_LOST_KHR;
    if constexpr (kIs<Member, &gl::Api::GetGraphicsResetStatus>)
      return GL_UNKNOWN_CONTEXT_RESET_KHR;
    // The driver behind lives on, and will be asked again: nothing may stay mapped in it
    if constexpr (kIs<Member, &gl::Api::UnmapBuffer>) return driver<Member>(arguments...);
    return R();
  }
  if constexpr (kIs<Member, &gl::Api::GetError>)
    if (const GLenum error = std::exchange(faults.error, GL_NO_ERROR)) return error;
  if constexpr (kIs<Member, &gl::Api::FenceSync>) ++faults.fences;
  if constexpr (kIs<Member, &gl::Api::ClientWaitSync>)
    if (faults.defects.slow) return GL_TIMEOUT_EXPIRED;
  if constexpr (kIs<Member, &gl::Api::CheckFramebufferStatus>)
    if (faults.defects.refuses_float_targets &&
        (faults.attached == GL_RGBA16F || faults.attached == GL_RGBA32F))
      return GL_FRAMEBUFFER_UNSUPPORTED;
  if constexpr (kIs<Member, &gl::Api::GetGraphicsResetStatus>)
    if (!driver<Member>) return GL_NO_ERROR;
  if (!before<Member>(arguments...)) return R();
  inside_driver = true;
  struct Back {
    ~Back() { inside_driver = false; }
  } const back;
  if constexpr (std::is_void_v<R>) {
    driver<Member>(arguments...);
    after<Member>(arguments...);
  } else {
    return driver<Member>(arguments...);
  }
}

template <auto Member, class R, class... A>
void put_between(gl::Api& api, R(GL_APIENTRY* function)(A...)) {
  driver<Member> = function;
  api.*Member = through<Member, R, A...>;
}

/// For its lifetime every function of `api` goes through `faults`. One at a time. With
/// `reset_status` the driver can say that the context was lost, otherwise only its errors do.
class GlFaults {
 public:
  explicit GlFaults(gl::Api& api, bool reset_status = true) : api_(api) {
    faults = {};
#define FLUXGS_PUT_BETWEEN(name) put_between<&gl::Api::name>(api, api.name);
    FLUXGS_GL_FUNCTIONS(FLUXGS_PUT_BETWEEN)
    FLUXGS_GL_COMPUTE_FUNCTIONS(FLUXGS_PUT_BETWEEN)
    FLUXGS_PUT_BETWEEN(GetGraphicsResetStatus)
    FLUXGS_PUT_BETWEEN(QueryCounter)
    FLUXGS_PUT_BETWEEN(GetQueryObjectui64v)
#undef FLUXGS_PUT_BETWEEN
    if (!reset_status) api.GetGraphicsResetStatus = nullptr;
  }
  GlFaults(const GlFaults&) = delete;
  GlFaults& operator=(const GlFaults&) = delete;
  ~GlFaults() {
    if (faults.zeros != 0) driver<&gl::Api::DeleteBuffers>(1, &faults.zeros);
#define FLUXGS_PUT_BACK(name) api_.name = driver<&gl::Api::name>;
    FLUXGS_GL_FUNCTIONS(FLUXGS_PUT_BACK)
    FLUXGS_GL_COMPUTE_FUNCTIONS(FLUXGS_PUT_BACK)
    FLUXGS_PUT_BACK(GetGraphicsResetStatus)
    FLUXGS_PUT_BACK(QueryCounter)
    FLUXGS_PUT_BACK(GetQueryObjectui64v)
#undef FLUXGS_PUT_BACK
  }

 private:
  gl::Api& api_;
};

}  // namespace fluxgs::test
