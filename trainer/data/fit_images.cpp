#include "trainer/data/fit_images.h"

#include "trainer/data/file_list.h"
#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

/// Images by the warning that they need.
struct ImageFindings {
  FailedImages unreadable;
  FileList turned, unturned, swapped, scaled;
};

/// False for a frame that is to be left out.
bool fit(SourceFrame& frame, ImageFindings& found) {
  const std::string file = frame.file.string();
  const auto image = read_image_outline(frame.file);
  if (!image) {
    found.unreadable.add(file, image.error());
    return false;
  }
  ImageSize size = image->size;
  const ImageSize turned{size.height, size.width};
  if (swaps_sides(frame.orientation)) {
    size = turned;
  } else if (!has_shape(frame.lens, size)) {
    if (!has_shape(frame.lens, turned)) {
      found.scaled.add(file);
    } else if (swaps_sides(image->exif.orientation)) {
      found.turned.add(file);
      frame.orientation = image->exif.orientation;
      size = turned;
    } else {
      found.swapped.add(file);
      return false;
    }
  } else if (frame.orientation == 1 && image->exif.orientation != 1) {
    found.unturned.add(file);
  }
  frame.lens = lens_for_image(frame.lens, size.width, size.height);
  return true;
}

void fit(std::vector<SourceFrame>& frames, ImageFindings& found) {
  std::erase_if(frames, [&](SourceFrame& frame) { return !fit(frame, found); });
}

}  // namespace

void fit_to_images(Source& source) {
  ImageFindings found;
  fit(source.frames, found);
  fit(source.test_frames, found);
  source.skipped_images += found.unreadable.size() + found.swapped.size();
  auto& warnings = source.warnings;
  found.unreadable.warn(warnings);
  if (!found.turned.empty())
    warnings.push_back("lying on their side, turned as EXIF says: " + found.turned.text());
  if (!found.unturned.empty())
    warnings.push_back(
        "used as stored, since their cameras fit that, although EXIF turns them (they may lie on "
        "their side or head): " +
        found.unturned.text());
  if (!found.swapped.empty())
    warnings.push_back(
        "left out, since width and height are swapped against their camera and EXIF names no "
        "turn: " +
        found.swapped.text());
  if (!found.scaled.empty())
    warnings.push_back("not of the shape of their camera, which is scaled each way by itself: " +
                       found.scaled.text());
}

}  // namespace fluxgs
