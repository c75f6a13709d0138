// A checked network that onnxruntime runs, on one thread and row by row.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/networks/mlp.h"
#include "networks/onnx_api.h"
#include "networks/onnx_check.h"
#include "networks/onnx_session.h"

namespace fluxgs::networks {

/// A scene may cost this much: rows times RowCost::work. That is 20 million splats through Ψ and Φ
/// of the paper, and about ten seconds of one core.
inline constexpr std::uint64_t kMaxWork = std::uint64_t{1} << 38;

/// Rows that are evaluated at once at most; fewer if the values between would exceed 16 MiB.
inline constexpr std::size_t kMaxBatch = 2048;

/// Not thread-safe; different objects are independent.
class OnnxNetwork {
 public:
  /// Reads and checks the bytes (onnx_check.h), then loads onnxruntime and hands it the model as
  /// written anew by us: it never sees a byte of a stranger's file.
  static Expected<OnnxNetwork> load(std::span<const std::byte> bytes, const Signature& signature,
                                    const Place& place);

  /// Rows for one run().
  std::size_t batch() const { return batch_; }

  /// Fails if `rows` rows would take too long.
  Expected<void> check_rows(std::size_t rows) const;

  /// Evaluates up to batch() rows: inputs[i] holds rows × columns of the signature's input i,
  /// row-major, `output` has room for rows × the output's columns. An error if a result is not
  /// finite, or if onnxruntime fails.
  Expected<void> run(std::size_t rows, std::span<const std::span<const float>> inputs,
                     std::span<float> output);

 private:
  OnnxNetwork(const ort::Runtime& runtime, Signature signature, Place place, RowCost cost);
  Expected<void> copy_output(ort::Value* value, std::size_t rows, std::span<float> output) const;

  const ort::Runtime* runtime_;
  Signature signature_;
  Place place_;
  RowCost cost_;
  std::size_t batch_;
  ort::Owned<ort::MemoryInfo> memory_;
  ort::Owned<ort::Session> session_;
};

}  // namespace fluxgs::networks
