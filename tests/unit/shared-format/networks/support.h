// Helpers of the network tests: random networks, models written field by field, and whether
// onnxruntime is here.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "fluxgs/networks/mlp.h"
#include "fluxgs/networks/onnx_runtime.h"
#include "networks/protobuf.h"
#include "support/needs_onnxruntime.h"

namespace fluxgs::networks::test {

using Bytes = std::vector<std::byte>;

/// Whether the library is in this process.
inline bool onnxruntime_is_loaded() {
  std::ifstream maps("/proc/self/maps");
  const std::string text{std::istreambuf_iterator<char>(maps), {}};
  return text.find("onnxruntime.so") != std::string::npos;
}

/// Weights as after training: normal, He initialisation; ReLU between the layers.
inline Mlp random_mlp(const std::vector<int>& sizes, unsigned seed) {
  std::mt19937 random(seed);
  Mlp mlp;
  for (std::size_t i = 0; i + 1 < sizes.size(); ++i) {
    std::normal_distribution<float> normal(0, std::sqrt(2.0f / static_cast<float>(sizes[i])));
    MlpLayer layer{.inputs = sizes[i],
                   .outputs = sizes[i + 1],
                   .weights = std::vector<float>(static_cast<std::size_t>(sizes[i] * sizes[i + 1])),
                   .bias = std::vector<float>(static_cast<std::size_t>(sizes[i + 1])),
                   .relu = i + 2 < sizes.size()};
    for (float& w : layer.weights) w = normal(random);
    for (float& b : layer.bias) b = 0.1f * normal(random);
    mlp.layers.push_back(std::move(layer));
  }
  return mlp;
}

inline std::vector<float> random_rows(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<float> values(count);
  for (float& v : values) v = normal(random);
  return values;
}

/// Fields of Protocol Buffers as bytes.
inline Bytes integer(std::uint32_t number, std::int64_t value) {
  FieldWriter out;
  out.integer(number, value);
  return out.take();
}
inline Bytes message(std::uint32_t number, const Bytes& value) {
  FieldWriter out;
  out.bytes(number, value);
  return out.take();
}
inline Bytes text(std::uint32_t number, std::string_view value) {
  FieldWriter out;
  out.text(number, value);
  return out.take();
}
inline Bytes floats(std::uint32_t number, std::span<const float> values) {
  FieldWriter out;
  out.bytes(number, std::as_bytes(values));
  return out.take();
}
inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// The parts of the model  y[N,2] = Gemm(x[N,3], w[2,3], transB = 1), to be changed by tests.
struct RawModel {
  Bytes dims = integer(1, 2) + integer(1, 3);
  Bytes element = integer(2, 1);
  Bytes values = floats(9, std::vector<float>{1, 2, 3, 4, 5, 6});
  Bytes tensor;  // more fields of the tensor
  Bytes attribute = text(1, "transB") + integer(3, 1) + integer(20, 2);
  Bytes node = text(1, "x") + text(1, "w") + text(2, "y") + text(4, "Gemm");
  Bytes rows = text(2, "N");
  Bytes columns = integer(1, 3);
  Bytes input_element = integer(1, 1);
  Bytes value;  // more fields of the input
  Bytes graph;  // more fields of the graph
  Bytes opset = text(1, "") + integer(2, 17);
  Bytes ir_version = integer(1, 8);
  Bytes model;  // more fields of the model

  Bytes bytes() const {
    const auto matrix = [](const Bytes& element_type, const Bytes& n, const Bytes& c) {
      return message(2, message(1, element_type + message(2, message(1, n) + message(1, c))));
    };
    const Bytes all =
        message(1, node + message(5, attribute)) +
        message(5, dims + element + text(8, "w") + values + tensor) +
        message(11, text(1, "x") + matrix(input_element, rows, columns) + value) +
        message(12, text(1, "y") + matrix(integer(1, 1), text(2, "N"), integer(1, 2))) + graph;
    return ir_version + message(7, all) + message(8, opset) + model;
  }
};
inline const Signature kRawSignature{{{"x", 3}}, {"y", 2}};

/// Fails unless `result` is an error whose one-line message has all of `parts`.
template <class T>
void expect_error(const Expected<T>& result, const std::vector<std::string>& parts) {
  ASSERT_FALSE(result.has_value()) << "expected an error with " << parts.front();
  const std::string said = result.error().message();
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  for (const std::string& part : parts) {
    EXPECT_NE(said.find(part), std::string::npos) << "no \"" << part << "\" in: " << said;
  }
}

}  // namespace fluxgs::networks::test
