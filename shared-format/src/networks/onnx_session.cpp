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

Expected<void> wrap(const Api& api, const MemoryInfo* memory, std::span<const float> values,
                    std::span<const std::int64_t> shape, Owned<Value>& tensor) {
  return take(api, tensor, "input", [&](auto** made) {
    // Inputs are not written to; the interface just has no type for that
    return api.wrap_tensor(memory, const_cast<float*>(values.data()), values.size_bytes(),
                           shape.data(), shape.size(), kFloat, made);
  });
}

Expected<FloatTensor> float_tensor(const Api& api, Value* tensor) {
  Owned<ShapeInfo> info(nullptr, api.release_shape);
  std::size_t rank = 0;
  int type = 0;
  void* data = nullptr;
  FloatTensor found;
  auto ok = take(api, info, "output", [&](auto** made) { return api.shape_of(tensor, made); });
  if (ok) ok = check(api, api.element_type(info.get(), &type), "output");
  if (ok) ok = check(api, api.rank(info.get(), &rank), "output");
  if (ok) found.shape.resize(type == kFloat ? rank : 0);
  if (ok && !found.shape.empty())
    ok = check(api, api.dimensions(info.get(), found.shape.data(), rank), "output");
  if (ok) ok = check(api, api.tensor_data(tensor, &data), "output");
  if (!ok) return std::unexpected(ok.error());
  found.values = static_cast<const float*>(data);
  return found;
}

}  // namespace fluxgs::networks::ort
