// Images from one layout to the other, and how far two are apart.
#pragma once

#include <algorithm>
#include <cmath>

#include "fluxgs/image.h"
#include "trainer/core/planar_image.h"

namespace fluxgs::cli {

/// The first three channels of interleaved pixels.
template <class T>
PlanarImage planes_of(const Image<T>& image) {
  PlanarImage out(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) out.row(c, y)[x] = static_cast<float>(image.at(x, y)[c]);
  return out;
}

/// The other way round.
inline Image<float> interleaved(const PlanarImage& planes) {
  Image<float> image(planes.width(), planes.height(), 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = planes.row(c, y)[x];
  return image;
}

/// Of two images of one size, limited to 0…1, over all channels.
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

}  // namespace fluxgs::cli
