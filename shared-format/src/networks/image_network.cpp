#include "fluxgs/networks/image_network.h"

#include <array>
#include <cstdint>

#include <fmt/format.h>

#include "networks/onnx_session.h"

namespace fluxgs::networks {

struct ImageNetwork::Session {
  Session(const ort::Runtime& loaded, std::vector<std::string> names)
      : runtime(loaded),
        outputs(std::move(names)),
        memory(nullptr, loaded.api.release_memory_info),
        session(nullptr, loaded.api.release_session) {}

  Expected<FeatureMap> feature_map(ort::Owned<ort::Value> value) const;

  const ort::Runtime& runtime;
  std::vector<std::string> outputs;
  ort::Owned<ort::MemoryInfo> memory;
  ort::Owned<ort::Session> session;
};

Expected<ImageNetwork> ImageNetwork::load(std::span<const std::byte> model,
                                          std::vector<std::string> outputs, int threads) {
  const auto runtime = ort::load_runtime();
  if (!runtime) return std::unexpected(runtime.error());
  auto session = std::make_shared<Session>(**runtime, std::move(outputs));
  auto ok = ort::create_session(**runtime, model, threads, session->memory, session->session);
  if (!ok) return std::unexpected(ok.error());
  return ImageNetwork(std::move(session));
}

Expected<FeatureMap> ImageNetwork::Session::feature_map(ort::Owned<ort::Value> value) const {
  const auto found = ort::float_tensor(runtime.api, value.get());
  if (!found) return std::unexpected(found.error());
  const std::vector<std::int64_t>& shape = found->shape;
  if (shape.size() != 4 || shape[0] != 1)
    return fail("onnxruntime", "output", "is not float32 of 1 × channels × height × width");
  FeatureMap map;
  map.channels = static_cast<int>(shape[1]);
  map.height = static_cast<int>(shape[2]);
  map.width = static_cast<int>(shape[3]);
  map.values = {found->values, static_cast<std::size_t>(shape[1] * shape[2] * shape[3])};
  const auto release = runtime.api.release_value;
  map.owner = std::shared_ptr<const void>(value.release(), [release](const void* owned) {
    release(static_cast<ort::Value*>(const_cast<void*>(owned)));
  });
  return map;
}

Expected<std::vector<FeatureMap>> ImageNetwork::run(std::span<const float> planes, int height,
                                                    int width) const {
  const ort::Api& api = session_->runtime.api;
  if (height < 1 || width < 1 ||
      planes.size() != 3 * static_cast<std::size_t>(height) * static_cast<std::size_t>(width))
    return fail("network", "image", fmt::format("is not 3 planes of {}×{}", width, height));
  const std::array<std::int64_t, 4> shape{1, 3, height, width};
  ort::Owned<ort::Value> input(nullptr, api.release_value);
  auto ok = ort::wrap(api, session_->memory.get(), planes, shape, input);
  if (!ok) return std::unexpected(ok.error());
  const std::size_t count = session_->outputs.size();
  std::vector<const char*> names;
  for (const std::string& name : session_->outputs) names.push_back(name.c_str());
  std::vector<ort::Value*> made(count, nullptr);
  const char* input_name = "image";
  const ort::Value* input_value = input.get();
  ok = ort::check(api,
                  api.run(session_->session.get(), nullptr, &input_name, &input_value, 1,
                          names.data(), count, made.data()),
                  "run");
  std::vector<FeatureMap> maps;
  for (ort::Value* value : made) {
    ort::Owned<ort::Value> owner(value, api.release_value);
    if (!ok) continue;
    auto map = session_->feature_map(std::move(owner));
    if (map) maps.push_back(std::move(*map));
    if (!map) ok = std::unexpected(map.error());
  }
  if (!ok) return std::unexpected(ok.error());
  return maps;
}

}  // namespace fluxgs::networks
