#include "networks/onnx_network.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "networks/flush_denormals.h"
#include "networks/onnx_session.h"

namespace fluxgs::networks {
namespace {

constexpr std::uint64_t kBatchFloats = (std::uint64_t{16} << 20) / sizeof(float);

std::size_t batch_of(const RowCost& cost) {
  const auto rows = kBatchFloats / std::max<std::uint64_t>(cost.columns, 1);
  return static_cast<std::size_t>(std::clamp<std::uint64_t>(rows, 1, kMaxBatch));
}

/// An error of onnxruntime's, in the file that it is about.
std::unexpected<Error> blame(const Place& place, const Error& error) {
  return fail(place.in(error.field), error.what);
}

}  // namespace

OnnxNetwork::OnnxNetwork(const ort::Runtime& runtime, Signature signature, Place place,
                         RowCost cost)
    : runtime_(&runtime),
      signature_(std::move(signature)),
      place_(std::move(place)),
      cost_(cost),
      batch_(batch_of(cost)),
      memory_(nullptr, runtime.api.release_memory_info),
      session_(nullptr, runtime.api.release_session) {}

Expected<OnnxNetwork> OnnxNetwork::load(std::span<const std::byte> bytes,
                                        const Signature& signature, const Place& place) {
  const auto model = read_onnx(bytes, place);
  if (!model) return std::unexpected(model.error());
  const auto cost = check_onnx(*model, signature, place);
  if (!cost) return std::unexpected(cost.error());
  const auto runtime = ort::load_runtime();
  if (!runtime) return std::unexpected(runtime.error());
  OnnxNetwork network(**runtime, signature, place, *cost);
  const auto ours = write_onnx(*model);
  if (auto ok = ort::create_session(**runtime, ours, 1, network.memory_, network.session_); !ok)
    return blame(place, ok.error());
  return network;
}

Expected<void> OnnxNetwork::check_rows(std::size_t rows) const {
  if (rows <= kMaxWork / std::max<std::uint64_t>(cost_.work, 1)) return {};
  return fail(place_, fmt::format("{} splats of {} multiply-adds each; at most {} in all are "
                                  "accepted",
                                  rows, cost_.work, kMaxWork));
}

Expected<void> OnnxNetwork::run(std::size_t rows, std::span<const std::span<const float>> inputs,
                                std::span<float> output) {
  const ort::Api& api = runtime_->api;
  const auto count = signature_.inputs.size();
  const auto sized = [&](std::size_t size, const Columns& columns) {
    return size == rows * static_cast<std::size_t>(columns.count);
  };
  bool fits = rows <= batch_ && inputs.size() == count && sized(output.size(), signature_.output);
  for (std::size_t i = 0; fits && i < count; ++i) {
    fits = sized(inputs[i].size(), signature_.inputs[i]);
  }
  if (!fits) return fail(place_, "its inputs or output are not of the size of its rows");
  if (rows == 0) return {};

  std::vector<ort::Owned<ort::Value>> owners;
  std::vector<const ort::Value*> values;
  std::vector<const char*> names;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array shape{static_cast<std::int64_t>(rows),
                           std::int64_t{signature_.inputs[i].count}};
    owners.emplace_back(nullptr, api.release_value);
    const auto ok = ort::wrap(api, memory_.get(), inputs[i], shape, owners.back());
    if (!ok) return blame(place_, ok.error());
    values.push_back(owners.back().get());
    names.push_back(signature_.inputs[i].name.c_str());
  }
  ort::Owned<ort::Value> result(nullptr, api.release_value);
  const char* output_name = signature_.output.name.c_str();
  const FlushDenormals flush;
  auto ok = ort::take(api, result, "run", [&](auto** made) {
    return api.run(session_.get(), nullptr, names.data(), values.data(), count, &output_name, 1,
                   made);
  });
  if (!ok) return blame(place_, ok.error());
  return copy_output(result.get(), rows, output);
}

Expected<void> OnnxNetwork::copy_output(ort::Value* value, std::size_t rows,
                                        std::span<float> output) const {
  const auto found = ort::float_tensor(runtime_->api, value);
  if (!found) return blame(place_, found.error());
  const std::array expected{static_cast<std::int64_t>(rows), std::int64_t{signature_.output.count}};
  if (!std::ranges::equal(found->shape, expected)) {
    return fail(place_.in("onnxruntime"), "its output is not a float32 matrix of the right size");
  }
  std::memcpy(output.data(), found->values, output.size_bytes());
  const auto bad = std::ranges::find_if(output, [](float v) { return !std::isfinite(v); });
  if (bad != output.end()) {
    return fail(place_, fmt::format("output column {} is not finite for a splat",
                                    (bad - output.begin()) % signature_.output.count));
  }
  return {};
}

}  // namespace fluxgs::networks
