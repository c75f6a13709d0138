// OpenGL ES 3.1 through EGL, without a surface: the driver's, and ANGLE's from a folder of one's
// own.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

// clang-format off
#define EGL_NO_X11
#define MESA_EGL_NO_X11_HEADERS
#include <EGL/egl.h>
#include <EGL/eglext.h>
// clang-format on

#include "platform/host/dynamic_library.h"
#include "platform/host/host_context.h"

namespace fluxgs::host {
namespace {

// EGL_ANGLE_platform_angle, …_vulkan and …_device_type_swiftshader (ANGLE's extension texts); the
// Khronos headers of Debian 12 do not have them.
constexpr EGLenum kPlatformAngle = 0x3202;
constexpr EGLint kAngleType = 0x3203, kAngleTypeVulkan = 0x3450;
constexpr EGLint kAngleDeviceType = 0x3209, kAngleDeviceSwiftShader = 0x3487;
constexpr EGLint kAngleNativePlatform = 0x348F;
// EGL_ANGLE_create_context_backwards_compatible
constexpr EGLint kAngleBackwardsCompatible = 0x3483;

// The functions used, and the display. Both live as long as the process: a terminated display
// would take the contexts of others with it.
struct Egl {
  DynamicLibrary library, gles;
  bool is_angle = false;
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLConfig config = nullptr;
  decltype(&::eglGetProcAddress) GetProcAddress = nullptr;
  decltype(&::eglInitialize) Initialize = nullptr;
  decltype(&::eglBindAPI) BindAPI = nullptr;
  decltype(&::eglChooseConfig) ChooseConfig = nullptr;
  decltype(&::eglCreateContext) CreateContext = nullptr;
  decltype(&::eglDestroyContext) DestroyContext = nullptr;
  decltype(&::eglMakeCurrent) MakeCurrent = nullptr;
  decltype(&::eglGetError) GetError = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplay = nullptr;
  // EGL_EXT_device_enumeration and EGL_EXT_device_query; null where the library lacks them
  PFNEGLQUERYDEVICESEXTPROC QueryDevices = nullptr;
  PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceString = nullptr;

  void* proc(const char* name) const {
    if (void* address = reinterpret_cast<void*>(GetProcAddress(name))) return address;
    // ANGLE's eglGetProcAddress leaves some functions to libGLESv2
    return is_angle ? gles.symbol(name) : nullptr;
  }
};

std::string hexadecimal(EGLint error) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%x", static_cast<unsigned>(error));
  return text;
}

bool load_functions(Egl& egl) {
  egl.library.load(egl.GetProcAddress, "eglGetProcAddress");
  egl.library.load(egl.Initialize, "eglInitialize");
  egl.library.load(egl.BindAPI, "eglBindAPI");
  egl.library.load(egl.ChooseConfig, "eglChooseConfig");
  egl.library.load(egl.CreateContext, "eglCreateContext");
  egl.library.load(egl.DestroyContext, "eglDestroyContext");
  egl.library.load(egl.MakeCurrent, "eglMakeCurrent");
  egl.library.load(egl.GetError, "eglGetError");
  if (!egl.GetProcAddress || !egl.Initialize || !egl.BindAPI || !egl.ChooseConfig ||
      !egl.CreateContext || !egl.DestroyContext || !egl.MakeCurrent || !egl.GetError) {
    return false;
  }
  egl.GetPlatformDisplay = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      egl.GetProcAddress("eglGetPlatformDisplayEXT"));
  egl.QueryDevices =
      reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.GetProcAddress("eglQueryDevicesEXT"));
  egl.QueryDeviceString = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(
      egl.GetProcAddress("eglQueryDeviceStringEXT"));
  return egl.GetPlatformDisplay != nullptr;
}

bool initialize(Egl& egl, EGLenum platform, void* native, const EGLint* attributes) {
  egl.display = egl.GetPlatformDisplay(platform, native, attributes);
  return egl.display != EGL_NO_DISPLAY && egl.Initialize(egl.display, nullptr, nullptr);
}

// The first graphics card that can be opened. Drivers that have no displays without a surface have
// those of a card, and where several drivers are installed the one of the processor must not win.
bool initialize_card(Egl& egl) {
  if (!egl.QueryDevices || !egl.QueryDeviceString) return false;
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (!egl.QueryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count)) return false;
  for (EGLint i = 0; i < count; ++i) {
    const char* extensions = egl.QueryDeviceString(devices[i], EGL_EXTENSIONS);
    const bool software = !extensions || std::strstr(extensions, "EGL_MESA_device_software");
    if (!software && initialize(egl, EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr)) return true;
  }
  return false;
}

Expected<void> open_display(Egl& egl, const char* where, EGLenum platform,
                            const EGLint* attributes) {
  if (!load_functions(egl)) return fail(where, "", "lacks functions of EGL 1.5");
  const bool opened =
      (!egl.is_angle && initialize_card(egl)) || initialize(egl, platform, nullptr, attributes);
  if (!opened) {
    return fail(where, "display",
                "cannot be opened without a window system (EGL error " +
                    hexadecimal(egl.GetError()) + "); install the package libegl-mesa0");
  }
  egl.BindAPI(EGL_OPENGL_ES_API);
  const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                           EGL_OPENGL_ES3_BIT, EGL_NONE};
  EGLint count = 0;
  // Without a configuration EGL_KHR_no_config_context serves: nothing is drawn to a surface.
  if (!egl.ChooseConfig(egl.display, wanted, &egl.config, 1, &count) || count < 1)
    egl.config = nullptr;
  return {};
}

Expected<Egl> open_driver() {
  Egl egl;
  auto library =
      DynamicLibrary::open({"libEGL.so.1"}, "install the packages libegl1 and libegl-mesa0");
  if (!library) return std::unexpected(library.error());
  egl.library = *library;
  auto opened = open_display(egl, "libEGL.so.1", EGL_PLATFORM_SURFACELESS_MESA, nullptr);
  if (!opened) return std::unexpected(opened.error());
  return egl;
}

Expected<Egl> open_angle() {
  const std::string folder = angle_folder();
  const std::string advice =
      "run tools/deps/angle, or name the folder with ANGLE's libEGL.so, libGLESv2.so and "
      "libvk_swiftshader.so in the variable FLUXGS_ANGLE_DIR";
  Egl egl;
  auto library = DynamicLibrary::open({folder + "/libEGL.so"}, advice);
  if (!library) return std::unexpected(library.error());
  auto gles = DynamicLibrary::open({folder + "/libGLESv2.so"}, advice);
  if (!gles) return std::unexpected(gles.error());
  egl.library = *library;
  egl.gles = *gles;
  egl.is_angle = true;
  const EGLint attributes[] = {kAngleType,
                               kAngleTypeVulkan,
                               kAngleDeviceType,
                               kAngleDeviceSwiftShader,
                               kAngleNativePlatform,
                               EGL_PLATFORM_SURFACELESS_MESA,
                               EGL_NONE};
  auto opened = open_display(egl, "ANGLE", kPlatformAngle, attributes);
  if (!opened) return std::unexpected(opened.error());
  return egl;
}

class EglContext final : public HostContext {
 public:
  static Expected<std::unique_ptr<HostContext>> create(const Expected<Egl>& egl) {
    if (!egl) return std::unexpected(egl.error());
    std::unique_ptr<EglContext> context(new EglContext(*egl));
    if (auto ok = context->open(); !ok) return std::unexpected(ok.error());
    return context;
  }

  ~EglContext() override {
    release();
    if (context_ != EGL_NO_CONTEXT) egl_.DestroyContext(egl_.display, context_);
  }

 private:
  explicit EglContext(const Egl& egl) : egl_(egl) {}

  Expected<void> open() {
    egl_.BindAPI(EGL_OPENGL_ES_API);
    for (const auto& [debug, reset] :
         {std::pair(true, true), {true, false}, {false, true}, {false, false}}) {
      context_ = egl_.CreateContext(egl_.display, egl_.config, EGL_NO_CONTEXT,
                                    attributes(debug, reset).data());
      if (context_ != EGL_NO_CONTEXT) break;
    }
    if (context_ == EGL_NO_CONTEXT) {
      return fail(
          "EGL", "context",
          "the driver offers no OpenGL ES 3.1 (EGL error " + hexadecimal(egl_.GetError()) + ")");
    }
    return load([this](const char* name) { return egl_.proc(name); });
  }

  // 3.1, so that nothing newer is used by accident. A driver may return a later, compatible
  // version, and Mesa's does; ANGLE is told not to, and refuses what is newer.
  // `debug`: with messages; `reset`: told when the GPU was reset. Not every driver has them.
  std::vector<EGLint> attributes(bool debug, bool reset) const {
    std::vector<EGLint> list = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 1};
    if (egl_.is_angle) list.insert(list.end(), {kAngleBackwardsCompatible, EGL_FALSE});
    if (debug) list.insert(list.end(), {EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE});
    if (reset) {
      list.insert(list.end(),
                  {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
    }
    list.push_back(EGL_NONE);
    return list;
  }

  bool bind() override {
    egl_.BindAPI(EGL_OPENGL_ES_API);
    return egl_.MakeCurrent(egl_.display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  void unbind() override {
    egl_.MakeCurrent(egl_.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  const Egl& egl_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::string angle_folder() {
  const char* named = std::getenv("FLUXGS_ANGLE_DIR");
  if (named && *named) return named;
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto installed = program.parent_path().parent_path() / "lib/fluxgs/angle";
  return std::filesystem::exists(installed, error) ? installed.string() : FLUXGS_ANGLE_FOLDER;
}

Expected<std::unique_ptr<HostContext>> create_egl_context() {
  static const Expected<Egl> egl = open_driver();
  return EglContext::create(egl);
}

Expected<std::unique_ptr<HostContext>> create_angle_context() {
  static const Expected<Egl> egl = open_angle();
  return EglContext::create(egl);
}

}  // namespace fluxgs::host
