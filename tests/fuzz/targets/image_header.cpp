// Headers of image files, and the Exif data inside of them.
#include "trainer/data/image_header.h"

#include <cmath>

#include "harness.h"

namespace fluxgs::fuzz {

FLUXGS_FUZZ_TARGET(image_header) {
  const Meter meter;
  const auto header = parse_image_header(input);
  check_memory(meter.peak(), {16 << 10, 0}, input.size(), 0);
  if (!header) return Worth::keep;
  const Exif& exif = header->exif;
  require(exif.orientation >= 1 && exif.orientation <= 8, "an orientation is one of eight");
  require(exif.camera.size() <= 201, "names are cut");
  for (const char c : exif.camera) require(c >= ' ' && c <= '~', "names can be printed");
  const double focal = exif.focal_pixels(4000, 3000);
  require(focal >= 0 && std::isfinite(focal), "a focal length, or none");
  if (const auto& p = exif.position)
    require(std::abs(p->x) <= 90 && std::abs(p->y) <= 180 && std::isfinite(p->z),
            "a place on earth");
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
