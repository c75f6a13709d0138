#include "fluxgs/networks/mlp.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "networks/onnx_check.h"

namespace fluxgs::networks {
namespace {

bool finite(const std::vector<float>& values) {
  return std::ranges::all_of(values, [](float v) { return std::isfinite(v); });
}

Expected<void> check_signature(const Mlp& mlp, const Signature& signature) {
  int inputs = 0;
  for (const Columns& input : signature.inputs) inputs += input.count;
  if (inputs != mlp.layers.front().inputs || signature.output.count != mlp.layers.back().outputs) {
    return fail("", "network",
                fmt::format("has {} inputs and {} outputs; its signature says {} and {}",
                            mlp.layers.front().inputs, mlp.layers.back().outputs, inputs,
                            signature.output.count));
  }
  return {};
}

}  // namespace

Expected<void> check_mlp(const Mlp& mlp) {
  if (mlp.layers.empty()) return fail("", "network", "has no layers");
  for (std::size_t i = 0; i < mlp.layers.size(); ++i) {
    const MlpLayer& layer = mlp.layers[i];
    const auto wrong = [&](const char* what) {
      return fail("", fmt::format("network: layer {}", i), what);
    };
    const bool sizes = layer.inputs >= 1 && layer.inputs <= kMaxColumns && layer.outputs >= 1 &&
                       layer.outputs <= kMaxColumns;
    if (!sizes) return wrong("its inputs and outputs must be 1 to 1024 each");
    const auto rows = static_cast<std::size_t>(layer.outputs);
    if (layer.weights.size() != rows * static_cast<std::size_t>(layer.inputs) ||
        layer.bias.size() != rows) {
      return wrong("its weights or bias are not of its size");
    }
    if (i > 0 && mlp.layers[i - 1].outputs != layer.inputs) {
      return wrong("its inputs are not the outputs of the layer before");
    }
    if (!finite(layer.weights) || !finite(layer.bias)) return wrong("a weight is not finite");
  }
  return {};
}

std::vector<double> evaluate(const Mlp& mlp, std::span<const double> row) {
  std::vector<double> values(row.begin(), row.end());
  for (const MlpLayer& layer : mlp.layers) {
    std::vector<double> next(layer.bias.begin(), layer.bias.end());
    for (std::size_t o = 0; o < next.size(); ++o) {
      const float* weights = layer.weights.data() + o * values.size();
      for (std::size_t i = 0; i < values.size(); ++i) next[o] += double{weights[i]} * values[i];
      if (layer.relu) next[o] = std::max(0.0, next[o]);
    }
    values = std::move(next);
  }
  return values;
}

Expected<std::vector<std::byte>> encode_onnx(const Mlp& mlp, const Signature& signature) {
  if (auto ok = check_mlp(mlp); !ok) return std::unexpected(ok.error());
  if (auto ok = check_signature(mlp, signature); !ok) return std::unexpected(ok.error());
  OnnxModel model;
  model.inputs = signature.inputs;
  model.outputs = {signature.output};
  std::string value = signature.inputs.front().name;
  if (signature.inputs.size() > 1) {
    Node concat{.op = "Concat", .inputs = {}, .outputs = {"row"}, .attributes = {}};
    for (const Columns& input : signature.inputs) concat.inputs.push_back(input.name);
    concat.attributes.push_back({"axis", std::int64_t{1}});
    model.nodes.push_back(std::move(concat));
    value = "row";
  }
  for (std::size_t i = 0; i < mlp.layers.size(); ++i) {
    const MlpLayer& layer = mlp.layers[i];
    const bool last = i + 1 == mlp.layers.size();
    const std::string weights = fmt::format("weights{}", i), bias = fmt::format("bias{}", i);
    const std::string sum = last && !layer.relu ? signature.output.name : fmt::format("sum{}", i);
    model.tensors.push_back({weights, {layer.outputs, layer.inputs}, layer.weights});
    model.tensors.push_back({bias, {layer.outputs}, layer.bias});
    model.nodes.push_back({"Gemm", {value, weights, bias}, {sum}, {{"transB", std::int64_t{1}}}});
    value = sum;
    if (layer.relu) {
      value = last ? signature.output.name : fmt::format("relu{}", i);
      model.nodes.push_back({"Relu", {sum}, {value}, {}});
    }
  }
  // Names of the caller's choice could clash with ours
  if (auto ok = check_onnx(model, signature, {"", "network"}); !ok) {
    return std::unexpected(ok.error());
  }
  return write_onnx(model);
}

}  // namespace fluxgs::networks
