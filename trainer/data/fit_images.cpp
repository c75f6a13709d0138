#include "trainer/data/fit_images.h"

#include <fmt/format.h>

#include "trainer/data/file_list.h"
#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

/// What a warning is needed for.
struct ImageFindings {
  FileList unreadable, turned, swapped, scaled;
  std::string first_error;
};

/// False for a frame that is to be left out.
bool fit(SourceFrame& frame, ImageFindings& found) {
  const std::string file = frame.file.string();
  const auto image = read_image_outline(frame.file);
  if (!image) {
    if (found.unreadable.empty()) found.first_error = image.error().message();
    found.unreadable.add(file);
    return false;
  }
  ImageSize size = image->size;
  const ImageSize turned{size.height, size.width};
  if (!has_shape(frame.lens, size)) {
    if (!has_shape(frame.lens, turned)) {
      found.scaled.add(file);
    } else if (swaps_sides(image->orientation)) {
      found.turned.add(file);
      frame.orientation = image->orientation;
      size = turned;
    } else {
      found.swapped.add(file);
      return false;
    }
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
  if (found.unreadable.size() == 1)
    warnings.push_back(found.first_error + "; it is left out");
  else if (!found.unreadable.empty())
    warnings.push_back(fmt::format("{} images cannot be read and are left out: {}; the first: {}",
                                   found.unreadable.size(), found.unreadable.text(),
                                   found.first_error));
  if (!found.turned.empty())
    warnings.push_back("lying on their side, turned as EXIF says: " + found.turned.text());
  if (!found.swapped.empty())
    warnings.push_back(
        "left out, since width and height are swapped against their camera and EXIF does not say "
        "how "
        "to turn them: " +
        found.swapped.text());
  if (!found.scaled.empty())
    warnings.push_back("not of the shape of their camera, which is scaled each way by itself: " +
                       found.scaled.text());
}

}  // namespace fluxgs
