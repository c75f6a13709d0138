#include "trainer/data/lens.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace fluxgs {

bool is_distorted(const Lens& lens) {
  // The others bend straight lines even where their coefficients are zeros.
  if (lens.model != LensModel::kPerspective) return true;
  return std::ranges::any_of(lens.distortion, [](double k) { return k != 0; });
}

Expected<void> check_lens(const Lens& lens, const std::string& file, const std::string& field) {
  const long long pixels = static_cast<long long>(lens.width) * lens.height;
  if (lens.width < 1 || lens.height < 1 || pixels > kMaxPixels)
    return fail(file, field,
                fmt::format("image size {}x{}, expected 1 to {} pixels", lens.width, lens.height,
                            kMaxPixels));
  const bool focal_ok = std::isfinite(lens.fx) && std::isfinite(lens.fy) && lens.fx > 0 &&
                        lens.fy > 0 && lens.fx < 1e9 && lens.fy < 1e9;
  if (!focal_ok)
    return fail(
        file, field,
        fmt::format("focal length {:g}, {:g}, expected pixels, more than 0 and less than 1e9",
                    lens.fx, lens.fy));
  if (!(std::abs(lens.cx) < 1e9) || !(std::abs(lens.cy) < 1e9))
    return fail(
        file, field,
        fmt::format("principal point {:g}, {:g}, expected numbers of pixels", lens.cx, lens.cy));
  if (!std::ranges::all_of(lens.distortion, [](double k) { return std::isfinite(k); }))
    return fail(file, field, "distortion that is not finite, expected numbers");
  return {};
}

Lens lens_for_image(const Lens& lens, int width, int height) {
  Lens scaled = lens;
  scaled.width = width;
  scaled.height = height;
  scaled.fx *= static_cast<double>(width) / lens.width;
  scaled.cx *= static_cast<double>(width) / lens.width;
  scaled.fy *= static_cast<double>(height) / lens.height;
  scaled.cy *= static_cast<double>(height) / lens.height;
  return scaled;
}

bool has_shape(const Lens& lens, ImageSize size) {
  // One side may be rounded by up to a pixel while the other fits exactly.
  const double skew = std::abs(static_cast<double>(size.width) * lens.height -
                               static_cast<double>(size.height) * lens.width);
  return skew <= std::max({lens.width, lens.height, size.width, size.height});
}

}  // namespace fluxgs
