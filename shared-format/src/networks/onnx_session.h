// Objects of onnxruntime that let themselves go, and the options of a session.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

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

}  // namespace fluxgs::networks::ort
