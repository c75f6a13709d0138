// Objects of onnxruntime that let themselves go, and the options of a session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "networks/onnx_api.h"

namespace fluxgs::networks::ort {

template <class T>
using Owned = std::unique_ptr<T, void (*)(T*)>;

/// Takes over what `create` made; what it made of a failure is an error.
template <class T, class Create>
Expected<void> take(const Api& api, Owned<T>& owner, const char* what, Create create) {
  T* made = nullptr;
  auto ok = check(api, create(&made), what);
  if (ok) owner.reset(made);
  return ok;
}

/// A session of a model that is in memory, and what describes memory of the CPU. Memory goes back
/// after each run.
Expected<void> create_session(const Runtime& runtime, std::span<const std::byte> model, int threads,
                              Owned<MemoryInfo>& memory, Owned<Session>& session);

/// A tensor over values that must outlive it.
Expected<void> wrap(const Api& api, const MemoryInfo* memory, std::span<const float> values,
                    std::span<const std::int64_t> shape, Owned<Value>& tensor);

/// The content of a tensor of float32, which owns it.
struct FloatTensor {
  std::vector<std::int64_t> shape = {};  ///< empty for a tensor of another type
  const float* values = nullptr;
};
Expected<FloatTensor> float_tensor(const Api& api, Value* tensor);

}  // namespace fluxgs::networks::ort
