// Trainable parameters of a scene, laid out for SIMD: one row for each scalar parameter.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// Rows of a PlanarFloats that holds splat parameters, their gradients or their Adam moments.
namespace row {
inline constexpr int position = 0;   // 3
inline constexpr int log_scale = 3;  // 3
inline constexpr int rotation = 6;   // 4: w, x, y, z
inline constexpr int opacity = 10;   // 1: logit
inline constexpr int sh_dc = 11;     // 3
inline constexpr int sh_rest = 14;   // 3 per coefficient: row sh_rest + 3·k + channel
inline constexpr int count(int sh_degree) { return sh_rest + 3 * sh_rest_count(sh_degree); }
}  // namespace row

/// `rows` arrays of `size` floats each; every row is 64-byte aligned and padded with zeros to a
/// multiple of kPadding entries, so that kernels may always work on whole packs of lanes.
class PlanarFloats {
 public:
  static constexpr std::size_t kPadding = 16;

  PlanarFloats() = default;
  PlanarFloats(int rows, std::size_t size);
  PlanarFloats(const PlanarFloats& other);
  PlanarFloats& operator=(const PlanarFloats& other);
  PlanarFloats(PlanarFloats&&) noexcept = default;
  PlanarFloats& operator=(PlanarFloats&&) noexcept = default;

  int rows() const { return rows_; }
  std::size_t size() const { return size_; }
  std::size_t stride() const { return stride_; }  ///< floats from row to row
  float* data() { return data_.get(); }
  const float* data() const { return data_.get(); }
  float* row(std::integral auto r) { return data_.get() + static_cast<std::size_t>(r) * stride_; }
  const float* row(std::integral auto r) const {
    return data_.get() + static_cast<std::size_t>(r) * stride_;
  }

  /// A copy holding column order[i] at i; entries of `order` that are kNew give zeros.
  static constexpr std::uint32_t kNew = 0xffffffffu;
  PlanarFloats gather(const std::vector<std::uint32_t>& order) const;

 private:
  struct Free {
    void operator()(float* p) const;
  };
  int rows_ = 0;
  std::size_t size_ = 0, stride_ = 0;
  std::unique_ptr<float[], Free> data_;
};

/// The quaternion of splat i, not normalised.
inline glm::dquat rotation_of(const PlanarFloats& parameters, std::size_t i) {
  const auto q = [&](int c) { return double{parameters.row(row::rotation + c)[i]}; };
  return glm::dquat(q(0), q(1), q(2), q(3));
}

/// The SH degree that rows of parameters hold, 0…3.
int sh_degree_of(const PlanarFloats& parameters);

/// The parameters of a cloud, at degree `sh_degree` ≥ the cloud's own (missing bands are zero).
PlanarFloats to_parameters(const SplatCloud& cloud, int sh_degree);
SplatCloud to_cloud(const PlanarFloats& parameters, int sh_degree);

}  // namespace fluxgs
