// The inner loop of the networks' training: one matrix product, in the three forms that a layer
// needs. Matrices are row by row, their rows 64-byte aligned and padded with zeros to a multiple of
// 16 floats (PlanarFloats), so that lanes run along the columns and no sum crosses them.
#pragma once

#include <cstddef>

#include "trainer/core/isa.h"

namespace fluxgs {

/// Operation on A·B before it is stored.
enum class MlpEpilogue {
  bias,       ///< C = A·B + extra, a row of `columns` floats
  bias_relu,  ///< C = max(0, A·B + extra)
  mask,       ///< C = A·B where extra > 0, else 0; `extra` is a matrix with C's stride
  store,      ///< C = A·B
  add,        ///< C += A·B
};

/// C[r][c] = Σ_k A[r][k]·B[k][c]. A may be read transposed: entry (r, k) is at
/// a[r·a_row + k·a_step].
struct MlpProductArgs {
  const float* a;
  std::size_t a_row, a_step;
  const float* b;  ///< aligned, as c and extra
  std::size_t b_stride;
  float* c;
  std::size_t c_stride;
  std::size_t rows, columns, depth;  ///< columns: a multiple of 16
  MlpEpilogue epilogue;
  const float* extra;  ///< what the epilogue needs, or null
};

struct MlpKernels {
  /// Every entry of C is summed in the order of k, whatever the instruction set: those with fused
  /// multiply-add give the same bytes.
  void (*product)(const MlpProductArgs&);
};

const MlpKernels& mlp_kernels(Isa isa);

}  // namespace fluxgs
