// A small multi-layer perceptron in float32 while it is trained: ReLU between the layers, batches
// of rows, derivatives by back-propagation, Adam. networks::evaluate() is its float64 reference.
//
// Rows are worked on in pieces of kMlpPiece. Sums over rows are taken within a piece in their
// order, so that results do not depend on who works on which piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/networks/mlp.h"
#include "trainer/core/adam.h"
#include "trainer/core/parameters.h"
#include "trainer/core/random.h"
#include "trainer/paper/mlp_kernels.h"

namespace fluxgs {

/// The most rows of one call, a multiple of the kernels' tile: the values of a piece stay in the
/// second-level cache.
inline constexpr std::size_t kMlpPiece = 96;

/// One matrix for each layer: a row for each input, with a column for each output, then a row for
/// the bias. Padding is zero and stays so.
using MlpMatrices = std::vector<PlanarFloats>;

struct TrainableMlp {
  std::vector<int> sizes;  ///< columns: of the input, the hidden layers, the output
  MlpMatrices weights;
  MlpMatrices first, second;  ///< Adam's moments
  int steps = 0;              ///< of Adam

  std::size_t layers() const { return weights.size(); }
};

/// Weights and biases uniform in ±1/√inputs of their layer; the last layer zero on demand, so that
/// the network begins as the constant 0. `sizes` has two entries or more, all positive.
TrainableMlp make_mlp(std::vector<int> sizes, bool zero_last_layer, Random& random);

/// Matrices of the network's shape, all zero.
MlpMatrices make_matrices(const std::vector<int>& sizes);

/// Values of the forward pass that the backward pass needs, by layer: the inputs, and the values of
/// hidden layers. Those of the first hidden layer are computed again: they are the largest part,
/// and cost as much to fetch from memory.
struct MlpBatch {
  MlpMatrices values;  ///< [layer] → [row][column]; values[1] is empty
};

/// Room for `rows` rows; never shrinks. The contents are then undefined.
void reserve(MlpBatch& batch, const TrainableMlp& mlp, std::size_t rows);

/// Evaluates the inputs in rows [begin, end) of the batch, at most kMlpPiece; results go to the
/// first rows of `outputs`, a matrix of kMlpPiece rows with the network's output columns.
void forward(const TrainableMlp& mlp, MlpBatch& batch, std::size_t begin, std::size_t end,
             PlanarFloats& outputs, const MlpKernels& kernels);

/// The weights as the backward pass reads them, made once for each pass. The first layer's are
/// those of the input columns that a gradient is wanted for.
struct MlpTransposed {
  MlpMatrices weights;  ///< [layer] → [output][input]
};
void transpose(const TrainableMlp& mlp, int first_input, int inputs, MlpTransposed& out);

/// Given ∂L/∂outputs in the first rows of `output_gradient` (its padding zero), adds ∂L/∂weights to
/// `gradient` and writes ∂L/∂inputs, of the columns chosen by transpose(), to the first rows of
/// `input_gradient`, a matrix of kMlpPiece rows. forward() must have been called for these rows.
/// The derivative of ReLU at 0 is 0.
void backward(const TrainableMlp& mlp, const MlpTransposed& transposed, const MlpBatch& batch,
              std::size_t begin, std::size_t end, const PlanarFloats& output_gradient,
              MlpMatrices& gradient, PlanarFloats& input_gradient, const MlpKernels& kernels);

/// One step of Adam. Weights whose gradient is not finite keep their value and moments; returns how
/// many there were.
std::uint64_t adam_step(TrainableMlp& mlp, const MlpMatrices& gradient, double rate,
                        const AdamConstants& constants, const AdamKernels& kernels);

/// Forgets Adam's moments and steps.
void reset_adam(TrainableMlp& mlp);

networks::Mlp to_mlp(const TrainableMlp& mlp);

/// Floats of to_floats() for these sizes.
std::size_t float_count(const std::vector<int>& sizes);

/// Everything but the sizes as one list, for checkpoints: the steps (in two halves, as floats are
/// exact to 2²⁴ only), then weights and both moments layer by layer, without padding.
std::vector<float> to_floats(const TrainableMlp& mlp);

/// Back from that; an error if the list has not float_count() entries.
Expected<TrainableMlp> mlp_from_floats(const std::vector<int>& sizes,
                                       std::span<const float> floats);

}  // namespace fluxgs
