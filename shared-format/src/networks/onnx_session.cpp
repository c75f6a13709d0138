#include "networks/onnx_session.h"

namespace fluxgs::networks::ort {

Expected<void> create_session(const Runtime& runtime, std::span<const std::byte> model, int threads,
                              Owned<MemoryInfo>& memory, Owned<Session>& session) {
  const Api& api = runtime.api;
  Owned<SessionOptions> owner(nullptr, api.release_options);
  auto ok = take(api, owner, "options", [&](auto** made) { return api.create_options(made); });
  SessionOptions* options = owner.get();
  const auto set = [&](auto function, auto... values) {
    if (ok) ok = check(api, function(options, values...), "options");
  };
  set(api.set_threads, threads);  // 1: no pool of threads
  set(api.set_optimization, kOptimizeAll);
  set(api.disable_arena);
  set(api.disable_memory_pattern);
  set(api.add_config, "session.load_model_format", "ONNX");  // never guessed from the bytes
  if (ok) {
    ok = take(api, memory, "memory", [&](auto** made) {
      return api.create_memory_info(kDeviceAllocator, kDefaultMemory, made);
    });
  }
  if (ok) {
    ok = take(api, session, "load", [&](auto** made) {
      return api.create_session(runtime.env, model.data(), model.size(), options, made);
    });
  }
  return ok;
}

}  // namespace fluxgs::networks::ort
