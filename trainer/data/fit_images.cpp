#include "trainer/data/fit_images.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "trainer/data/file_list.h"
#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

constexpr int kMostReduced = 32;  // camera by image; smaller ones are no reduced copies

/// Images by the warning that they need.
struct ImageFindings {
  FailedImages unreadable;
  FileList turned, swapped, scaled;
  /// EXIF turns by files whose shape does not tell whether their poses are for the turned image.
  std::map<std::filesystem::path, int> open;
  bool some_stored = false;  ///< others have poses for the image as its file holds it
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
  const Lens& lens = frame.lens;
  if (kMostReduced * std::max(size.width, size.height) < std::max(lens.width, lens.height)) {
    found.unreadable.add(
        file, Error{file, "",
                    fmt::format("is {}x{} pixels, its camera says {}x{}", size.width, size.height,
                                lens.width, lens.height)});
    return false;
  }
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
    const bool either = !swaps_sides(image->exif.orientation) || has_shape(frame.lens, turned);
    found.some_stored = found.some_stored || !either;
    if (either) found.open.emplace(frame.file, image->exif.orientation);
  }
  frame.lens = lens_for_image(frame.lens, size.width, size.height);
  return true;
}

void fit(std::vector<SourceFrame>& frames, ImageFindings& found) {
  std::erase_if(frames, [&](SourceFrame& frame) { return !fit(frame, found); });
}

/// One program found all poses: photos whose shape tells nothing are turned if others are.
void decide_open(Source& source, ImageFindings& found) {
  const bool turns = !found.turned.empty() && !found.some_stored;
  FileList stored;
  for (auto* frames : {&source.frames, &source.test_frames})
    for (SourceFrame& frame : *frames) {
      const auto at = found.open.find(frame.file);
      if (at == found.open.end()) continue;
      (turns ? found.turned : stored).add(frame.file.string());
      if (turns) frame.orientation = at->second;
    }
  if (!stored.empty())
    source.warnings.push_back(
        "EXIF says to turn these photos, but their poses may be for the photo as its file holds "
        "it, and they are not turned: " +
        stored.text());
}

}  // namespace

void fit_to_images(Source& source) {
  ImageFindings found;
  fit(source.frames, found);
  fit(source.test_frames, found);
  decide_open(source, found);
  source.skipped_images += found.unreadable.size() + found.swapped.size();
  auto& warnings = source.warnings;
  found.unreadable.warn(warnings);
  if (!found.turned.empty())
    warnings.push_back("lying on their side, turned as EXIF says: " + found.turned.text());
  if (!found.swapped.empty())
    warnings.push_back(
        "left out, since width and height are swapped against their camera and EXIF names no "
        "turn: " +
        found.swapped.text());
  if (!found.scaled.empty())
    warnings.push_back(
        "width to height differs from their camera's, whose focal lengths are stretched to fit: " +
        found.scaled.text());
}

}  // namespace fluxgs
