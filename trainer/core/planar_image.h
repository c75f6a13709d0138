// Images as the kernels want them: one plane for each channel, rows padded with zeros.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fluxgs/image.h"
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

/// The first three channels of interleaved pixels as planes.
template <class T>
PlanarImage planes_of(const Image<T>& image) {
  PlanarImage out(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) out.row(c, y)[x] = static_cast<float>(image.at(x, y)[c]);
  return out;
}

/// Values as a display shows them, 0…1.
inline void limit_to_displayable(PlanarImage& image) {
  for (int c = 0; c < image.channels(); ++c)
    for (int y = 0; y < image.height(); ++y)
      for (float* p = image.row(c, y); p != image.row(c, y) + image.width(); ++p)
        *p = std::clamp(*p, 0.0f, 1.0f);
}

/// A plane of 1 where a mask of one channel and of the image's size is not 0, and 0 elsewhere.
inline void copy_mask(const Image<std::uint8_t>& mask, PlanarImage& image, int channel) {
  for (int y = 0; y < mask.height; ++y) {
    const std::uint8_t* from = mask.at(0, y);
    float* to = image.row(channel, y);
    for (int x = 0; x < mask.width; ++x) to[x] = from[x] == 0 ? 0.0f : 1.0f;
  }
}

/// Planes as interleaved RGB.
inline Image<float> interleaved(const PlanarImage& planes) {
  Image<float> image(planes.width(), planes.height(), 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = planes.row(c, y)[x];
  return image;
}

/// The largest difference of two RGB images of one size, both limited to 0…1.
inline double largest_difference(const PlanarImage& a, const PlanarImage& b) {
  double worst = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x)
        worst =
            std::max(worst, static_cast<double>(std::abs(std::clamp(a.row(c, y)[x], 0.0f, 1.0f) -
                                                         std::clamp(b.row(c, y)[x], 0.0f, 1.0f))));
  return worst;
}

}  // namespace fluxgs
