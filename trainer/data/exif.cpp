#include "trainer/data/exif.h"

#include <algorithm>
#include <cmath>

#include "trainer/data/stored_integer.h"

namespace fluxgs {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kOrientation = 274;

std::size_t tiff_size_of(std::uint32_t type) {
  switch (type) {
    case 1:  // byte
    case 2:  // text
    case 7:  // bytes of no stated meaning
      return 1;
    case 3:
      return 2;
    case 4:
      return 4;
    case 5:
      return 8;
    default:
      return 0;
  }
}

/// Degrees of three numbers: degrees, minutes, seconds. `negative`: south or west.
std::optional<double> degrees(const TiffDirectory& gps, std::uint32_t tag, char negative) {
  const auto values = gps.find(tag);
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto part = i < values.count ? gps.number(values, i) : std::nullopt;
    if (!part) return std::nullopt;
    sum += *part / std::pow(60.0, static_cast<double>(i));
  }
  return gps.text(tag - 1).starts_with(negative) ? -sum : sum;
}

std::optional<glm::dvec3> position_of(const TiffDirectory& gps) {
  constexpr std::uint32_t kLatitude = 2, kLongitude = 4, kBelowSea = 5, kAltitude = 6;
  const auto latitude = degrees(gps, kLatitude, 'S'), longitude = degrees(gps, kLongitude, 'W');
  if (!latitude || !longitude || std::abs(*latitude) > 90 || std::abs(*longitude) > 180)
    return std::nullopt;
  if (*latitude == 0 && *longitude == 0) return std::nullopt;  // what devices without a fix write
  const double up = gps.first_number(kAltitude).value_or(0);
  return glm::dvec3(*latitude, *longitude, gps.first(kBelowSea) == 1 ? -up : up);
}

double positive(std::optional<double> value) {
  return value && std::isfinite(*value) && *value > 0 ? *value : 0;
}

}  // namespace

TiffDirectory::TiffDirectory(Bytes file) : bytes_(file) {
  if (file.size() < 8) return;
  little_ = file[0] == 'I';
  begin_ = read(4, 4);
  count_ = read(begin_, 2);
}

TiffDirectory::TiffDirectory(Bytes file, bool little, std::size_t begin)
    : bytes_(file), little_(little), begin_(begin) {
  count_ = read(begin_, 2);
}

std::uint32_t TiffDirectory::read(std::size_t at, std::size_t size) const {
  if (at > bytes_.size() || bytes_.size() - at < size) return 0;
  return stored_integer(bytes_, at, size, little_);
}

TiffDirectory::Values TiffDirectory::find(std::uint32_t tag) const {
  constexpr std::size_t kEntry = 12;
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t at = begin_ + 2 + kEntry * i;
    if (at + kEntry > bytes_.size()) break;
    if (read(at, 2) != tag) continue;
    Values values{.at = at + 8, .size = tiff_size_of(read(at + 2, 2)), .count = read(at + 4, 4)};
    if (values.size * values.count > 4) values.at = read(at + 8, 4);
    if (values.size == 0 || values.at + values.size * values.count > bytes_.size()) break;
    return values;
  }
  return {};
}

std::uint32_t TiffDirectory::value(const Values& values, std::size_t index) const {
  return read(values.at + values.size * index, std::min<std::size_t>(values.size, 4));
}

std::optional<double> TiffDirectory::number(const Values& values, std::size_t index) const {
  const double numerator = value(values, index);
  if (values.size != 8) return numerator;
  const double denominator = read(values.at + 8 * index + 4, 4);
  return denominator > 0 ? std::optional(numerator / denominator) : std::nullopt;
}

std::optional<std::uint32_t> TiffDirectory::first(std::uint32_t tag) const {
  const Values values = find(tag);
  return values.count > 0 ? std::optional(value(values, 0)) : std::nullopt;
}

std::optional<double> TiffDirectory::first_number(std::uint32_t tag) const {
  const Values values = find(tag);
  return values.count > 0 ? number(values, 0) : std::nullopt;
}

std::string TiffDirectory::text(std::uint32_t tag) const {
  constexpr std::size_t kLongest = 100;
  const Values values = find(tag);
  std::string text;
  for (std::size_t i = 0; values.size == 1 && i < std::min(values.count, kLongest); ++i) {
    const auto c = static_cast<char>(value(values, i));
    if (c == '\0') break;
    text += c > ' ' && c <= '~' ? c : ' ';
  }
  text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

TiffDirectory TiffDirectory::sub_directory(std::uint32_t tag) const {
  const auto begin = first(tag);
  return begin ? TiffDirectory(bytes_, little_, *begin) : TiffDirectory(Bytes());
}

double Exif::focal_pixels(int width, int height) const {
  constexpr double kFullFrameDiagonal = 43.2666;  // mm, of 36 × 24
  const double diagonal = std::hypot(width, height), longest = std::max(width, height);
  double pixels = focal_35mm / kFullFrameDiagonal * diagonal;
  if (pixels <= 0 && sensor_width > 0) pixels = focal_mm * pixels_per_mm * longest / sensor_width;
  return pixels > 0.2 * longest && pixels < 50 * longest ? pixels : 0;
}

Exif parse_exif(Bytes tiff) {
  constexpr std::uint32_t kMake = 271, kModel = 272, kExifDirectory = 34665, kGpsDirectory = 34853,
                          kFocal = 37386, kFocal35 = 41989, kWidth = 40962, kHeight = 40963,
                          kPlaneResolution = 41486, kPlaneUnit = 41488;
  const TiffDirectory main(tiff);
  const TiffDirectory detail = main.sub_directory(kExifDirectory);
  Exif exif;
  if (const auto value = main.first(kOrientation); value && *value >= 1 && *value <= 8)
    exif.orientation = static_cast<int>(*value);
  exif.camera = main.text(kMake) + " " + main.text(kModel);
  if (exif.camera == " ") exif.camera.clear();
  exif.focal_mm = positive(detail.first_number(kFocal));
  exif.focal_35mm = positive(detail.first_number(kFocal35));
  const bool centimetres = detail.first(kPlaneUnit) == 3;  // otherwise inches
  exif.pixels_per_mm = positive(detail.first_number(kPlaneResolution)) / (centimetres ? 10 : 25.4);
  exif.sensor_width =
      std::max(positive(detail.first_number(kWidth)), positive(detail.first_number(kHeight)));
  exif.position = position_of(main.sub_directory(kGpsDirectory));
  return exif;
}

void remove_orientation(std::span<std::uint8_t> tiff) {
  const auto value = TiffDirectory(tiff).find(kOrientation);
  if (value.count != 1) return;
  std::ranges::fill(tiff.subspan(value.at, value.size), std::uint8_t{0});
  tiff[tiff[0] == 'I' ? value.at : value.at + value.size - 1] = 1;
}

}  // namespace fluxgs
