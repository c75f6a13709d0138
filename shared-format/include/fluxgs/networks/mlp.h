// Small multi-layer perceptrons: plain weights, their evaluation in float64, and the ONNX model
// that a scene file carries.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::networks {

/// y = W·x + b, then max(0, y) if `relu`.
struct MlpLayer {
  int inputs = 0;              ///< 1 to 1024
  int outputs = 0;             ///< 1 to 1024
  std::vector<float> weights;  ///< [output][input]
  std::vector<float> bias;     ///< [output]
  bool relu = false;           ///< max(0, y)
};

/// Layers one after the other: each has as many inputs as the one before has outputs.
struct Mlp {
  std::vector<MlpLayer> layers;  ///< from input to output
};

/// A matrix of a network by name: one row a splat, this many columns.
struct Columns {
  std::string name;  ///< of the ONNX input or output
  int count = 0;     ///< columns
};

/// Inputs of a network, side by side in this order, and its outputs.
struct Signature {
  std::vector<Columns> inputs;  ///< in order
  Columns output;               ///< the only one
};

/// An error if there are no layers, sizes disagree or a weight is not finite.
Expected<void> check_mlp(const Mlp& mlp);

/// The output for one row of input, computed in float64: the reference for faster evaluations. The
/// network must pass check_mlp() and `row` must have as many entries as it has inputs.
std::vector<double> evaluate(const Mlp& mlp, std::span<const double> row);

/// The network as an ONNX model (IR version 8, operator set 17; one Concat if there are several
/// inputs, then Gemm and Relu) that check_onnx() accepts. The inputs' columns must add up to those
/// of the first layer, the output's must be those of the last.
Expected<std::vector<std::byte>> encode_onnx(const Mlp& mlp, const Signature& signature);

}  // namespace fluxgs::networks
