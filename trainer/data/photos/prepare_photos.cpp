#include "trainer/data/photos/prepare_photos.h"

#include <algorithm>
#include <cctype>
#include <new>
#include <span>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "fluxgs/io/file.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/image_io.h"
#include "trainer/data/reduction.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

Expected<PreparedPhoto> outline_of(const Photo& photo) {
  const auto outline = read_image_outline(photo.file);
  if (!outline) return std::unexpected(outline.error());
  const Exif& exif = outline->exif;
  ImageSize size = outline->size;
  if (swaps_sides(exif.orientation)) std::swap(size.width, size.height);
  size = reduced_size(size, 0);
  const double focal = exif.focal_pixels(size.width, size.height);
  return PreparedPhoto{.photo = photo,
                       .copy = copy_name(photo.name),
                       .size = size,
                       .orientation = exif.orientation,
                       .focal = focal,
                       .camera = fmt::format("{}x{} f={:.0f} {:.2f} mm {}", size.width, size.height,
                                             focal, exif.focal_mm, exif.camera),
                       .position = exif.position};
}

Expected<void> write_copy(const PreparedPhoto& photo, const fs::path& target) {
  const std::string name = photo.photo.file.string();
  try {
    auto image = read_image(photo.photo.file);
    if (!image) return std::unexpected(image.error());
    *image = upright(*image, photo.orientation);
    cv::Mat pixels(image->height, image->width, CV_8UC(image->channels), image->pixels.data());
    cv::Mat bgr, reduced;
    cv::cvtColor(pixels, bgr, image->channels == 4 ? cv::COLOR_RGBA2BGR : cv::COLOR_RGB2BGR);
    cv::resize(bgr, reduced, {photo.size.width, photo.size.height}, 0, 0, cv::INTER_AREA);
    std::vector<std::uint8_t> jpeg;
    if (!cv::imencode(".jpg", reduced, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95}))
      return fail(name, "", "its reduced copy cannot be encoded");
    return write_file_atomic(target, std::as_bytes(std::span(jpeg)));
  } catch (const cv::Exception& e) {
    return fail(name, "", "the photo could not be processed: " + e.err);
  } catch (const std::bad_alloc&) {
    return fail(name, "", "not enough memory for the photo");
  }
}

Expected<PreparedPhoto> prepare_photo(const Photo& photo, const fs::path& folder) {
  auto prepared = outline_of(photo);
  if (!prepared) return prepared;
  const fs::path target = folder / prepared->copy;
  if (is_file(target)) return prepared;
  if (const auto ok = write_copy(*prepared, target); !ok) return std::unexpected(ok.error());
  return prepared;
}

}  // namespace

std::string copy_name(const std::string& name) {
  std::string copy;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == '.' || c == '-' || c == '_')
      copy += c;
    else
      copy += fmt::format("%{:02X}", byte);
  }
  return copy.ends_with(".jpg") || copy.ends_with(".jpeg") || copy.ends_with(".JPG")
             ? copy
             : copy + ".jpg";
}

Expected<std::vector<PreparedPhoto>> prepare_photos(const std::vector<Photo>& photos,
                                                    const fs::path& folder,
                                                    const StepReport& report,
                                                    std::vector<std::string>& warnings) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(folder.string(), "", "cannot be created: " + error.message());
  std::vector<Expected<PreparedPhoto>> made(photos.size(), fail("", "", ""));
  const bool any_missing = !std::ranges::all_of(
      photos, [&](const Photo& photo) { return is_file(folder / copy_name(photo.name)); });
  const ProgressReport progress = [&](std::size_t done, std::size_t total) {
    if (report && any_missing) report("reduced copies", "photos", done, total);
  };
  ProgressCounter counter(progress, photos.size());
  tbb::parallel_for(std::size_t{0}, photos.size(), [&](std::size_t i) {
    made[i] = prepare_photo(photos[i], folder);
    counter.add_one();
  });
  std::vector<PreparedPhoto> prepared;
  FailedImages failed;
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (made[i])
      prepared.push_back(std::move(*made[i]));
    else
      failed.add(photos[i].file.string(), made[i].error());
  }
  if (2 * failed.size() > photos.size()) return failed.failure(photos.size());
  failed.warn(warnings);
  return prepared;
}

}  // namespace fluxgs
