#include "platform/host/host_context.h"

#ifdef __SANITIZE_ADDRESS__
// GCC 12's sanitizer takes thread-local memory that lies 16 bytes into a page for a block with a
// header as glibc 2.19 had one, and what it reads there for an address. Where the memory of a
// thread of ANGLE happens to lie so, the leak check at exit crashes ("Tracer caught signal 11").
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" [[gnu::visibility("default")]] const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }  // NOLINT
#endif

namespace fluxgs::host {
namespace {

// The libraries do not know of each other: the one whose context is current on a thread must let
// go before another takes over, or both write into one dispatch table.
thread_local HostContext* current = nullptr;

}  // namespace

std::string_view name(HostGl implementation) {
  switch (implementation) {
    case HostGl::egl:
      return "egl";
    case HostGl::osmesa:
      return "osmesa";
    case HostGl::angle:
      return "angle";
  }
  return "";
}

Expected<HostGl> parse_host_gl(std::string_view text) {
  for (const HostGl implementation : {HostGl::egl, HostGl::osmesa, HostGl::angle})
    if (text == name(implementation)) return implementation;
  return fail("GL implementation", std::string(text), "unknown; egl, osmesa or angle was expected");
}

Expected<std::unique_ptr<HostContext>> HostContext::create(HostGl implementation) {
  switch (implementation) {
    case HostGl::egl:
      return create_egl_context();
    case HostGl::osmesa:
      return create_osmesa_context();
    case HostGl::angle:
      return create_angle_context();
  }
  return fail("GL implementation", "", "unknown");
}

Expected<void> HostContext::make_current() {
  if (current == this) return {};
  if (current) current->unbind();
  current = nullptr;
  if (!bind()) return fail("OpenGL", "context", "the driver could not make it current");
  current = this;
  return {};
}

Expected<void> HostContext::load(const gl::ProcLoader& loader) {
  if (auto ok = make_current(); !ok) return ok;
  auto api = gl::load_api(loader);
  if (!api) return std::unexpected(api.error());
  api_ = std::move(*api);
  gl::hook_debug_messages(*api_);
  return {};
}

void HostContext::release() {
  if (current != this) return;
  unbind();
  current = nullptr;
}

}  // namespace fluxgs::host
