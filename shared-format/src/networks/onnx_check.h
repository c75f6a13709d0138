// Checks that an ONNX model is a small network of the expected shape, before it runs.
#pragma once

#include <cstdint>

#include "networks/onnx_model.h"

namespace fluxgs::networks {

/// Cost of one row: bounds on time and memory.
struct RowCost {
  std::uint64_t work = 0;     ///< multiply-adds, or as long
  std::uint64_t columns = 0;  ///< floats of all values of a row together
};

/// A row may cost this much. Ψ and Φ as in the paper take 1,728 and 13,568.
inline constexpr std::uint64_t kMaxRowWork = std::uint64_t{1} << 20;

/// Follows the rows of the inputs through the graph. Refused by name: operators other than Gemm,
/// MatMul, Add, Sub, Mul, Div, Relu, LeakyRelu, Sigmoid, Tanh, Clip, Concat (of columns) and
/// Identity; attributes that mix rows (transA, another axis) or that the operator does not have;
/// values used before they are made or made twice; operands whose columns do not fit; inputs and
/// outputs other than those of the signature, in any order; more than kMaxRowWork.
Expected<RowCost> check_onnx(const OnnxModel& model, const Signature& signature,
                             const Place& place);

}  // namespace fluxgs::networks
