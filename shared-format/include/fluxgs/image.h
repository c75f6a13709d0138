// An image in memory.
#pragma once

#include <cstddef>
#include <memory_resource>
#include <vector>

namespace fluxgs {

/// Interleaved pixels, row-major from the top-left corner: pixels[(y·width + x)·channels + c].
/// Colours are display-referred (sRGB-encoded) as the images store them; floating-point types span
/// 0…1, 8-bit ones 0…255. Channels: 3 (RGB) or 4 (RGBA).
template <class T>
struct Image {
  int width = 0;               ///< pixels
  int height = 0;              ///< pixels
  int channels = 3;            ///< 3 or 4
  std::pmr::vector<T> pixels;  ///< width · height · channels values

  Image() = default;
  /// An image of zeros.
  Image(int w, int h, int c) : width(w), height(h), channels(c), pixels(size_of(w, h, c)) {}

  /// A copy with its pixels in that memory, which must outlive it.
  Image(const Image& other, std::pmr::memory_resource& memory)
      : width(other.width),
        height(other.height),
        channels(other.channels),
        pixels(other.pixels, &memory) {}

  /// The first channel of a pixel.
  T* at(int x, int y) { return pixels.data() + offset(x, y); }
  /// The first channel of a pixel.
  const T* at(int x, int y) const { return pixels.data() + offset(x, y); }

 private:
  static std::size_t size_of(int w, int h, int c) {
    return static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c);
  }
  std::size_t offset(int x, int y) const {
    return size_of(width, y, channels) + size_of(x, 1, channels);
  }
};

}  // namespace fluxgs
