#include "fluxgs/networks/onnx_runtime.h"

#include <dlfcn.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "networks/onnx_api.h"

namespace fluxgs::networks {
namespace ort {
namespace {

constexpr const char* kVariable = "FLUXGS_ONNXRUNTIME";
#ifdef FLUXGS_PHONE
constexpr const char* kAdvice =
    "scenes with networks need onnxruntime, which this app was built without: `fluxgs convert` "
    "makes "
    "one without networks of them";
#else
constexpr const char* kAdvice =
    "scenes with networks, and LPIPS, need onnxruntime 1.18 or later: run tools/setup, or name the "
    "library in the variable FLUXGS_ONNXRUNTIME";
#endif

/// Paths to look at; a library named by the user is the only one.
std::vector<std::string> candidates() {
  const char* named = std::getenv(kVariable);
  if (named != nullptr && *named != '\0') return {named};
  return {
#ifdef FLUXGS_ONNXRUNTIME_LIBRARY
      FLUXGS_ONNXRUNTIME_LIBRARY,
#endif
      "libonnxruntime.so.1", "libonnxruntime.so"};
}

struct Opened {
  void* handle = nullptr;
  std::string path;
};

/// Never closed: the library keeps threads and thread-local data.
Expected<Opened> open_library() {
  std::string path, reason;  // of the first, which is the one that is meant
  for (const std::string& name : candidates()) {
    if (void* handle = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)) return Opened{handle, name};
    const char* said = dlerror();
    if (path.empty()) reason = said != nullptr ? said : "no reason given";
    if (path.empty()) path = name;
  }
  return fail(path, "", fmt::format("cannot be loaded ({}); {}", reason, kAdvice));
}

/// "1.28.0" → 28, the number of its interface; nothing for another major version.
std::uint32_t interface_of(std::string_view version) {
  std::uint32_t minor = 0;
  if (!version.starts_with("1.")) return 0;
  std::from_chars(version.data() + 2, version.data() + version.size(), minor);
  return minor;
}

Api bind(const void* table) {
  const auto* slots = static_cast<void (*const*)()>(table);
  constexpr Slots at;
  Api api{};
  const auto set = [&](auto& function, std::size_t slot) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(slots[slot]);
  };
  set(api.error_message, at.error_message);
  set(api.create_env, at.create_env);
  set(api.disable_telemetry, at.disable_telemetry);
  set(api.create_session, at.create_session);
  set(api.run, at.run);
  set(api.create_options, at.create_options);
  set(api.disable_memory_pattern, at.disable_memory_pattern);
  set(api.disable_arena, at.disable_arena);
  set(api.set_optimization, at.set_optimization);
  set(api.set_threads, at.set_threads);
  set(api.wrap_tensor, at.wrap_tensor);
  set(api.tensor_data, at.tensor_data);
  set(api.element_type, at.element_type);
  set(api.rank, at.rank);
  set(api.dimensions, at.dimensions);
  set(api.shape_of, at.shape_of);
  set(api.create_memory_info, at.create_memory_info);
  set(api.add_config, at.add_config);
  set(api.release_status, at.release_status);
  set(api.release_memory_info, at.release_memory_info);
  set(api.release_session, at.release_session);
  set(api.release_value, at.release_value);
  set(api.release_shape, at.release_shape);
  set(api.release_options, at.release_options);
  return api;
}

Expected<Runtime> start() {
  // Before the library is loaded: with this, releases that send usage data neither set up an
  // uploader nor write an identifier of this machine to the disk.
  ::setenv("ORT_DISABLE_TELEMETRY", "1", 1);
  const auto library = open_library();
  if (!library) return std::unexpected(library.error());
  const auto get_base =
      reinterpret_cast<const ApiBase* (*)()>(dlsym(library->handle, "OrtGetApiBase"));
  const ApiBase* base = get_base == nullptr ? nullptr : get_base();
  if (base == nullptr) {
    return fail(library->path, "", fmt::format("is not onnxruntime; {}", kAdvice));
  }
  Runtime runtime{base->get_version(), library->path, {}, nullptr};
  const void* table =
      interface_of(runtime.version) < kApiVersion ? nullptr : base->get_api(kApiVersion);
  if (table == nullptr) {
    return fail(library->path, "", fmt::format("is onnxruntime {}; {}", runtime.version, kAdvice));
  }
  runtime.api = bind(table);
  // Errors come back as values; nothing is written to the terminal.
  auto ok = check(runtime.api, runtime.api.create_env(kLogFatal, "fluxgs", &runtime.env), "start");
  if (ok) ok = check(runtime.api, runtime.api.disable_telemetry(runtime.env), "telemetry");
  if (!ok) return std::unexpected(ok.error());
  return runtime;
}

}  // namespace

Expected<void> check(const Api& api, Status* status, const char* what) {
  if (status == nullptr) return {};
  const std::unique_ptr<Status, decltype(api.release_status)> owner(status, api.release_status);
  std::string text = api.error_message(status);
  text = text.substr(0, std::min<std::size_t>(text.find('\n'), 300));
  std::ranges::replace_if(text, [](char c) { return c < 0x20 || c > 0x7e; }, '?');
  return fail("", "onnxruntime", fmt::format("{}: {}", what, text));
}

Expected<const Runtime*> load_runtime() {
  static std::mutex mutex;
  static std::unique_ptr<Runtime> runtime;
  const std::lock_guard lock(mutex);
  if (!runtime) {
    auto started = start();
    if (!started) return std::unexpected(started.error());
    runtime = std::make_unique<Runtime>(std::move(*started));
  }
  return runtime.get();
}

}  // namespace ort

Expected<OnnxRuntimeInfo> onnx_runtime_info() {
  const auto runtime = ort::load_runtime();
  if (!runtime) return std::unexpected(runtime.error());
  return OnnxRuntimeInfo{(*runtime)->version, (*runtime)->path};
}

}  // namespace fluxgs::networks
