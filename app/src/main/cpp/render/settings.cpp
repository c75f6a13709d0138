#include "render/settings.h"

#include <cmath>
#include <string>

#include "sort/depth_keys.h"

namespace fluxgs::render {

ApproximationSettings default_approximation(const gl::Quirks& quirks) {
  constexpr int kPhoneKeyBits = 16;
  ApproximationSettings made;
  if (quirks.tiles) made.key_bits = kPhoneKeyBits;
  return made;
}

Expected<void> check_settings(const RendererSettings& s) {
  if (s.batch < 1 || s.batch > kMostQuads)
    return fail("renderer", "batch", std::to_string(s.batch) + " quads; 1…128 were expected");
  if (s.slices < 1 || s.slices > kMostSlices)
    return fail("renderer", "slices", std::to_string(s.slices) + "; 1 to 64 were expected");
  return check_approximation(s.approximation);
}

Expected<void> check_approximation(const ApproximationSettings& s) {
  if (s.key_bits < sort::kFewestKeyBits || s.key_bits > sort::kMaxKeyBits) {
    return fail("approximation", "key_bits",
                std::to_string(s.key_bits) + "; 10 to 32 were expected");
  }
  const auto amount = [](double v) { return std::isfinite(v) && v >= 0; };
  if (!amount(s.min_weight))
    return fail("approximation", "min_weight", "must be finite, not negative");
  if (!amount(s.max_deviations)) {
    return fail("approximation", "max_deviations", "must be finite, not negative");
  }
  if (!amount(s.resort_motion)) {
    return fail("approximation", "resort_motion", "must be finite, not negative");
  }
  return {};
}

}  // namespace fluxgs::render
