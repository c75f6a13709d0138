// Pictures as the kernels want them: one plane for each channel, rows padded with zeros.
#pragma once

#include <cstddef>
#include <vector>

namespace fluxgs {

/// `channels` planes of floats. A row holds `width` pixels and at least kGuard zeros after them,
/// with kGuard zeros before the first row, so that an 11-tap filter may read over both ends of a
/// row and packs of lanes may be loaded whole.
class PlanarImage {
 public:
  static constexpr int kGuard = 16;

  PlanarImage() = default;
  PlanarImage(int width, int height, int channels)
      : width_(width),
        height_(height),
        channels_(channels),
        pitch_((static_cast<std::size_t>(width) + 5 + 15) / 16 * 16),
        data_(kGuard + static_cast<std::size_t>(channels) * plane_size() + 2 * kGuard) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  std::size_t pitch() const { return pitch_; }  ///< floats from row to row
  std::size_t plane_size() const { return pitch_ * static_cast<std::size_t>(height_); }

  float* plane(int c) { return data_.data() + kGuard + static_cast<std::size_t>(c) * plane_size(); }
  const float* plane(int c) const {
    return data_.data() + kGuard + static_cast<std::size_t>(c) * plane_size();
  }
  float* row(int c, int y) { return plane(c) + static_cast<std::size_t>(y) * pitch_; }
  const float* row(int c, int y) const { return plane(c) + static_cast<std::size_t>(y) * pitch_; }

 private:
  int width_ = 0, height_ = 0, channels_ = 0;
  std::size_t pitch_ = 0;
  std::vector<float> data_;
};

}  // namespace fluxgs
