#include "trainer/data/lens_check.h"

#include <algorithm>

#include "trainer/data/file_list.h"

namespace fluxgs {
namespace {

constexpr double kShortest = 1.0 / 20;  // x the longer side: an angle of view of 168 degrees

bool is_short(const Lens& lens) {
  return std::max(lens.fx, lens.fy) < kShortest * std::max(lens.width, lens.height);
}

bool is_off_centre(const Lens& lens) {
  return lens.cx <= 0 || lens.cy <= 0 || lens.cx >= lens.width || lens.cy >= lens.height;
}

}  // namespace

void warn_of_lenses(Source& source) {
  FileList is_fraction, off_centre;
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames) {
      if (is_short(frame.lens)) is_fraction.add(frame.name);
      if (is_off_centre(frame.lens)) off_centre.add(frame.name);
    }
  if (!is_fraction.empty())
    source.warnings.push_back(
        "focal lengths of less than a twentieth of the image's longer side; expected pixels, not a "
        "fraction: " +
        is_fraction.text());
  if (!off_centre.empty())
    source.warnings.push_back(
        "principal points in the corner of the image or outside of it; expected pixels, near its "
        "middle (cx, cy): " +
        off_centre.text());
}

}  // namespace fluxgs
