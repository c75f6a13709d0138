// Images as the kernels want them: one plane for each channel, rows padded with zeros.
#pragma once

#include <cstddef>

#include "trainer/core/parameters.h"

namespace fluxgs {

/// `channels` planes of floats. Every row is 64-byte aligned and holds `width` pixels and zeros up
/// to pitch(), so that packs of lanes may be loaded whole.
class PlanarImage {
 public:
  PlanarImage() = default;
  PlanarImage(int width, int height, int channels)
      : width_(width),
        height_(height),
        channels_(channels),
        pitch_((static_cast<std::size_t>(width) + 15) / 16 * 16),
        data_(channels, plane_size()) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  std::size_t pitch() const { return pitch_; }  ///< floats from row to row
  std::size_t plane_size() const { return pitch_ * static_cast<std::size_t>(height_); }

  float* plane(int c) { return data_.row(c); }
  const float* plane(int c) const { return data_.row(c); }
  float* row(int c, int y) { return plane(c) + static_cast<std::size_t>(y) * pitch_; }
  const float* row(int c, int y) const { return plane(c) + static_cast<std::size_t>(y) * pitch_; }

 private:
  int width_ = 0, height_ = 0, channels_ = 0;
  std::size_t pitch_ = 0;
  PlanarFloats data_;
};

}  // namespace fluxgs
