#include "trainer/paper/trainable_mlp.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fluxgs {
namespace {

std::size_t size(int count) { return static_cast<std::size_t>(count); }

/// The padded row of entry `r` of a matrix.
const float* bias_of(const PlanarFloats& m) { return m.row(m.rows() - 1); }

/// Rows of a matrix, one after the other.
struct Rows {
  const float* data;
  std::size_t stride;
};

/// Memory for kMlpPiece rows that the calling thread keeps, one block for each layer.
float* scratch(std::size_t layer, std::size_t stride) {
  thread_local std::vector<PlanarFloats> blocks;
  if (blocks.size() <= layer) blocks.resize(layer + 1);
  if (blocks[layer].size() < kMlpPiece * stride)
    blocks[layer] = PlanarFloats(1, kMlpPiece * stride);
  return blocks[layer].data();
}

/// in · weights + bias, through ReLU but for the last layer.
void apply_layer(const TrainableMlp& mlp, std::size_t layer, const Rows& in, std::size_t rows,
                 float* out, const MlpKernels& kernels) {
  const PlanarFloats& w = mlp.weights[layer];
  const bool last = layer + 1 == mlp.layers();
  kernels.product({.a = in.data,
                   .a_row = in.stride,
                   .a_step = 1,
                   .b = w.data(),
                   .b_stride = w.stride(),
                   .c = out,
                   .c_stride = w.stride(),
                   .rows = rows,
                   .columns = w.stride(),
                   .depth = size(mlp.sizes[layer]),
                   .epilogue = last ? MlpEpilogue::bias : MlpEpilogue::bias_relu,
                   .extra = bias_of(w)});
}

/// Inputs of layer `layer` in rows [begin, end) of a batch.
Rows inputs_of(const TrainableMlp& mlp, std::size_t layer, const MlpBatch& batch, std::size_t begin,
               std::size_t end, const MlpKernels& kernels) {
  const PlanarFloats& kept = batch.values[layer];
  if (layer != 1) return {kept.row(begin), kept.stride()};
  const PlanarFloats& in = batch.values[0];
  const std::size_t stride = mlp.weights[0].stride();
  float* out = scratch(0, stride);
  apply_layer(mlp, 0, {in.row(begin), in.stride()}, end - begin, out, kernels);
  return {out, stride};
}

/// gradient += inᵀ · delta, and the bias's: 1ᵀ · delta.
void add_weight_gradient(const Rows& in, const Rows& delta, std::size_t rows,
                         PlanarFloats& gradient, const MlpKernels& kernels) {
  static constexpr float kOne = 1;
  const std::size_t stride = gradient.stride(), inputs = size(gradient.rows() - 1);
  MlpProductArgs product{.a = in.data,
                         .a_row = 1,
                         .a_step = in.stride,
                         .b = delta.data,
                         .b_stride = delta.stride,
                         .c = gradient.data(),
                         .c_stride = stride,
                         .rows = inputs,
                         .columns = stride,
                         .depth = rows,
                         .epilogue = MlpEpilogue::add,
                         .extra = nullptr};
  kernels.product(product);
  product.a = &kOne;
  product.a_row = product.a_step = 0;
  product.c = gradient.row(inputs);
  product.rows = 1;
  kernels.product(product);
}

/// out = delta · weightsᵀ; with `values` (of the same stride) only where those are positive.
void propagate(const Rows& delta, const PlanarFloats& transposed, const float* values,
               std::size_t rows, float* out, const MlpKernels& kernels) {
  kernels.product({.a = delta.data,
                   .a_row = delta.stride,
                   .a_step = 1,
                   .b = transposed.data(),
                   .b_stride = transposed.stride(),
                   .c = out,
                   .c_stride = transposed.stride(),
                   .rows = rows,
                   .columns = transposed.stride(),
                   .depth = size(transposed.rows()),
                   .epilogue = values ? MlpEpilogue::mask : MlpEpilogue::store,
                   .extra = values});
}

}  // namespace

MlpMatrices make_matrices(const std::vector<int>& sizes) {
  MlpMatrices matrices;
  for (std::size_t l = 0; l + 1 < sizes.size(); ++l)
    matrices.emplace_back(sizes[l] + 1, size(sizes[l + 1]));
  return matrices;
}

TrainableMlp make_mlp(std::vector<int> sizes, bool zero_last_layer, Random& random) {
  TrainableMlp mlp{.sizes = std::move(sizes), .weights = {}, .first = {}, .second = {}};
  mlp.weights = make_matrices(mlp.sizes);
  reset_adam(mlp);
  for (std::size_t l = 0; l < mlp.layers(); ++l) {
    if (zero_last_layer && l + 1 == mlp.layers()) break;
    PlanarFloats& w = mlp.weights[l];
    const double reach = 1 / std::sqrt(static_cast<double>(mlp.sizes[l]));
    for (int r = 0; r < w.rows(); ++r)
      for (std::size_t c = 0; c < w.size(); ++c)
        w.row(r)[c] = static_cast<float>(reach * (2 * uniform(random) - 1));
  }
  return mlp;
}

void reserve(MlpBatch& batch, const TrainableMlp& mlp, std::size_t rows) {
  batch.values.resize(mlp.layers());
  for (std::size_t l = 0; l < mlp.layers(); ++l) {
    PlanarFloats& values = batch.values[l];
    if (l == 1 || (size(values.rows()) >= rows && values.size() == size(mlp.sizes[l]))) continue;
    // A little more than asked for, as the number of visible splats changes from view to view
    values = PlanarFloats(static_cast<int>(rows + rows / 4), size(mlp.sizes[l]));
  }
}

void forward(const TrainableMlp& mlp, MlpBatch& batch, std::size_t begin, std::size_t end,
             PlanarFloats& outputs, const MlpKernels& kernels) {
  const std::size_t last = mlp.layers() - 1;
  for (std::size_t l = 1; l < last; ++l)
    apply_layer(mlp, l, inputs_of(mlp, l, batch, begin, end, kernels), end - begin,
                batch.values[l + 1].row(begin), kernels);
  apply_layer(mlp, last, inputs_of(mlp, last, batch, begin, end, kernels), end - begin,
              outputs.data(), kernels);
}

void transpose(const TrainableMlp& mlp, int first_input, int inputs, MlpTransposed& out) {
  out.weights.resize(mlp.layers());
  for (std::size_t l = 0; l < mlp.layers(); ++l) {
    const int offset = l == 0 ? first_input : 0, columns = l == 0 ? inputs : mlp.sizes[l];
    PlanarFloats& to = out.weights[l];
    if (to.rows() != mlp.sizes[l + 1] || to.size() != size(columns))
      to = PlanarFloats(mlp.sizes[l + 1], size(columns));
    for (int i = 0; i < columns; ++i) {
      const float* from = mlp.weights[l].row(offset + i);
      for (int o = 0; o < to.rows(); ++o) to.row(o)[i] = from[o];
    }
  }
}

void backward(const TrainableMlp& mlp, const MlpTransposed& transposed, const MlpBatch& batch,
              std::size_t begin, std::size_t end, const PlanarFloats& output_gradient,
              MlpMatrices& gradient, PlanarFloats& input_gradient, const MlpKernels& kernels) {
  const std::size_t rows = end - begin;
  Rows delta{output_gradient.data(), output_gradient.stride()};
  for (std::size_t l = mlp.layers(); l-- > 0;) {
    const Rows in = inputs_of(mlp, l, batch, begin, end, kernels);
    add_weight_gradient(in, delta, rows, gradient[l], kernels);
    if (l == 0)
      return propagate(delta, transposed.weights[0], nullptr, rows, input_gradient.data(), kernels);
    float* next = scratch(l, in.stride);
    propagate(delta, transposed.weights[l], in.data, rows, next, kernels);
    delta = {next, in.stride};
  }
}

std::uint64_t adam_step(TrainableMlp& mlp, const MlpMatrices& gradient, double rate,
                        const AdamConstants& constants, const AdamKernels& kernels) {
  ++mlp.steps;
  const AdamStep adam(constants, mlp.steps, kernels);
  std::uint64_t rejected = 0;
  std::vector<std::uint8_t> finite;
  for (std::size_t l = 0; l < mlp.layers(); ++l) {
    const PlanarFloats& g = gradient[l];
    const std::size_t count = size(g.rows()) * g.stride();
    finite.resize(count);
    for (std::size_t i = 0; i < count; ++i) finite[i] = std::isfinite(g.data()[i]) ? 1 : 0;
    rejected += static_cast<std::uint64_t>(std::ranges::count(finite, 0));
    adam.run({mlp.weights[l].data(), mlp.first[l].data(), mlp.second[l].data(), g.data(),
              finite.data(), rate},
             0, count);
  }
  return rejected;
}

void reset_adam(TrainableMlp& mlp) {
  mlp.first = make_matrices(mlp.sizes);
  mlp.second = make_matrices(mlp.sizes);
  mlp.steps = 0;
}

networks::Mlp to_mlp(const TrainableMlp& mlp) {
  networks::Mlp out;
  for (std::size_t l = 0; l < mlp.layers(); ++l) {
    const PlanarFloats& w = mlp.weights[l];
    networks::MlpLayer layer{.inputs = mlp.sizes[l],
                             .outputs = mlp.sizes[l + 1],
                             .weights = {},
                             .bias = {bias_of(w), bias_of(w) + w.size()},
                             .relu = l + 1 < mlp.layers()};
    for (int o = 0; o < layer.outputs; ++o)
      for (int i = 0; i < layer.inputs; ++i) layer.weights.push_back(w.row(i)[o]);
    out.layers.push_back(std::move(layer));
  }
  return out;
}

namespace {

constexpr std::size_t kStepFloats = 2;
constexpr int kStepBase = 1 << 16;

}  // namespace

std::size_t float_count(const std::vector<int>& sizes) {
  std::size_t weights = 0;
  for (std::size_t l = 0; l + 1 < sizes.size(); ++l) weights += size((sizes[l] + 1) * sizes[l + 1]);
  return kStepFloats + 3 * weights;
}

std::vector<float> to_floats(const TrainableMlp& mlp) {
  std::vector<float> out{static_cast<float>(mlp.steps / kStepBase),
                         static_cast<float>(mlp.steps % kStepBase)};
  out.reserve(float_count(mlp.sizes));
  for (const MlpMatrices* matrices : {&mlp.weights, &mlp.first, &mlp.second})
    for (const PlanarFloats& m : *matrices)
      for (int r = 0; r < m.rows(); ++r) out.insert(out.end(), m.row(r), m.row(r) + m.size());
  return out;
}

Expected<TrainableMlp> mlp_from_floats(const std::vector<int>& sizes,
                                       std::span<const float> floats) {
  if (floats.size() != float_count(sizes))
    return fail("", "network",
                fmt::format("{} values, expected {}", floats.size(), float_count(sizes)));
  TrainableMlp mlp{.sizes = sizes, .weights = make_matrices(sizes), .first = {}, .second = {}};
  reset_adam(mlp);
  const auto in_range = [](float half) { return half >= 0 && half < kStepBase / 2; };
  if (!in_range(floats[0]) || !(floats[1] >= 0 && floats[1] < kStepBase))
    return fail("", "network", "its number of iterations is out of range");
  mlp.steps = static_cast<int>(floats[0]) * kStepBase + static_cast<int>(floats[1]);
  const float* next = floats.data() + kStepFloats;
  for (MlpMatrices* matrices : {&mlp.weights, &mlp.first, &mlp.second})
    for (PlanarFloats& m : *matrices)
      for (int r = 0; r < m.rows(); ++r, next += m.size())
        std::copy(next, next + m.size(), m.row(r));
  return mlp;
}

}  // namespace fluxgs
