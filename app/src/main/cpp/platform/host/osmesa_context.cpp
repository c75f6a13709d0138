// Desktop OpenGL 4.5 through Mesa's off-screen library. Shaders of `#version 310 es` compile there
// because 4.5 includes ARB_ES3_1_compatibility.
#include <array>

#include "platform/host/dynamic_library.h"
#include "platform/host/host_context.h"

#ifdef __SANITIZE_ADDRESS__
// OSMesaDestroyContext forgets the 104-byte buffer that OSMesaMakeCurrent made (Mesa 22.3.6), and
// ANGLE what it keeps of a thread that has ended. With this the leak sanitizer, which asks the
// program for it, reports only leaks of ours. NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" [[gnu::visibility("default")]] const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {  // NOLINT
  return "leak:libOSMesa\nleak:egl::GetCurrentThread\n";
}
#endif

namespace fluxgs::host {
namespace {

// The few declarations needed of GL/osmesa.h (Mesa), which not every machine has installed.
constexpr int kFormat = 0x22, kRgba = 0x1908;
constexpr int kProfile = 0x33, kCoreProfile = 0x34;
constexpr int kMajorVersion = 0x36, kMinorVersion = 0x37;

struct OsMesa {
  DynamicLibrary library;
  void* (*CreateContextAttribs)(const int* attributes, void* share) = nullptr;
  void (*DestroyContext)(void* context) = nullptr;
  unsigned char (*MakeCurrent)(void* context, void* pixels, GLenum type, GLsizei width,
                               GLsizei height) = nullptr;
  void* (*GetProcAddress)(const char* name) = nullptr;
};

Expected<OsMesa> open_osmesa() {
  auto library =
      DynamicLibrary::open({"libOSMesa.so.8", "libOSMesa.so.6"}, "install the package libosmesa6");
  if (!library) return std::unexpected(library.error());
  OsMesa mesa;
  mesa.library = *library;
  library->load(mesa.CreateContextAttribs, "OSMesaCreateContextAttribs");
  library->load(mesa.DestroyContext, "OSMesaDestroyContext");
  library->load(mesa.MakeCurrent, "OSMesaMakeCurrent");
  library->load(mesa.GetProcAddress, "OSMesaGetProcAddress");
  if (mesa.CreateContextAttribs && mesa.DestroyContext && mesa.MakeCurrent && mesa.GetProcAddress)
    return mesa;
  return fail("libOSMesa", "", "lacks functions of Mesa 12 or later");
}

class OsMesaContext final : public HostContext {
 public:
  static Expected<std::unique_ptr<HostContext>> create(const Expected<OsMesa>& mesa) {
    if (!mesa) return std::unexpected(mesa.error());
    std::unique_ptr<OsMesaContext> context(new OsMesaContext(*mesa));
    if (auto ok = context->open(); !ok) return std::unexpected(ok.error());
    return context;
  }

  ~OsMesaContext() override {
    release();
    if (context_) mesa_.DestroyContext(context_);
  }

 private:
  explicit OsMesaContext(const OsMesa& mesa) : mesa_(mesa) {}

  Expected<void> open() {
    const int attributes[] = {kFormat,       kRgba, kProfile, kCoreProfile, kMajorVersion, 4,
                              kMinorVersion, 5,     0};
    context_ = mesa_.CreateContextAttribs(attributes, nullptr);
    if (!context_) return fail("OSMesa", "context", "the library offers no OpenGL 4.5");
    return load([this](const char* name) { return mesa_.GetProcAddress(name); });
  }

  bool bind() override {
    constexpr GLenum kUnsignedByte = GL_UNSIGNED_BYTE;
    return mesa_.MakeCurrent(context_, pixels_.data(), kUnsignedByte, kSide, kSide) != 0;
  }
  void unbind() override { mesa_.MakeCurrent(nullptr, nullptr, 0, 0, 0); }

  // The window that OSMesa insists on; images are drawn to framebuffer objects.
  static constexpr GLsizei kSide = 4;
  std::array<unsigned char, 4 * kSide * kSide> pixels_{};
  const OsMesa& mesa_;
  void* context_ = nullptr;
};

}  // namespace

Expected<std::unique_ptr<HostContext>> create_osmesa_context() {
  static const Expected<OsMesa> mesa = open_osmesa();
  return OsMesaContext::create(mesa);
}

}  // namespace fluxgs::host
