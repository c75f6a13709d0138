// An ONNX model as plain data: what is left of the format's messages for a network of matrix
// products. Whatever this cannot hold is refused while reading, so it cannot reach onnxruntime.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/networks/mlp.h"

namespace fluxgs::networks {

// onnx.proto3: TensorProto.DataType and AttributeProto.AttributeType
inline constexpr std::int64_t kFloat = 1;
inline constexpr std::int64_t kAttributeFloat = 1, kAttributeInt = 2;

/// File and place in it, for error messages.
struct Place {
  std::string file, field;

  Place in(const std::string& part) const {
    return {file, field.empty() ? part : field + ": " + part};
  }
};
using fluxgs::fail;
inline std::unexpected<Error> fail(const Place& place, std::string what) {
  return fluxgs::fail(place.file, place.field, std::move(what));
}

/// Bounds on what is read. Real networks here have about 10 nodes, 10 tensors and 60 KB.
inline constexpr std::size_t kMaxModelBytes = std::size_t{4} << 20;
inline constexpr std::size_t kMaxNodes = 64;
inline constexpr std::size_t kMaxTensors = 128;
inline constexpr std::size_t kMaxOperands = 16;  ///< of a node; also inputs and outputs of a model
inline constexpr std::size_t kMaxAttributes = 8;
inline constexpr std::size_t kMaxNameLength = 256;
inline constexpr int kMaxColumns = 1024;  ///< of every matrix
inline constexpr std::size_t kMaxRank = 2;

/// Operator sets in which the operators of onnx_check.h mean the same, and the versions of the
/// format that go with them.
inline constexpr std::int64_t kMinOpset = 13, kMaxOpset = 21;
inline constexpr std::int64_t kMinIrVersion = 3, kMaxIrVersion = 10;

/// A constant matrix, row-major.
struct Tensor {
  std::string name;
  std::vector<std::int64_t> dims;  ///< at most kMaxRank, each 1 to kMaxColumns; none: one number
  std::vector<float> values;       ///< finite
};

struct Attribute {
  std::string name;
  std::variant<float, std::int64_t> value;
};

struct Node {
  std::string op;
  std::vector<std::string> inputs, outputs;  ///< an input left out is empty
  std::vector<Attribute> attributes;
};

/// Names are printable ASCII of at most kMaxNameLength.
struct OnnxModel {
  std::int64_t ir_version = 8, opset = 17;
  std::vector<Node> nodes;
  std::vector<Tensor> tensors;
  std::vector<Columns> inputs, outputs;  ///< float32 matrices with any number of rows
};

/// Read a model's bytes into plain data (facts: onnx.proto3). Refused by name: external data,
/// element types other than float32, training information, functions, sub-graphs and other
/// attributes than single numbers, sparse tensors, quantization, other domains, what is beyond the
/// bounds above, repeated or unknown fields, weights that are not finite. Documentation, metadata
/// and the shapes of intermediate values are skipped. No recursion; memory is at most the size of
/// `bytes`. Whether the graph makes sense is left to check_onnx().
Expected<OnnxModel> read_onnx(std::span<const std::byte> bytes, const Place& place);

/// The bytes of a model; the same bytes every time.
std::vector<std::byte> write_onnx(const OnnxModel& model);

}  // namespace fluxgs::networks
