// Exif: the data that a camera writes into its photos.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <glm/vec3.hpp>

namespace fluxgs {

/// The first directory of a TIFF file, or another one of it (TIFF 6.0, section 2).
class TiffDirectory {
 public:
  /// `file` from the byte order mark on; it must outlive this object.
  explicit TiffDirectory(std::span<const std::uint8_t> file);

  /// Place of a tag's values, all of them inside of the file: bytes, texts, integers of 16 or 32
  /// bits, or rationals of two of these.
  struct Values {
    std::size_t at = 0, size = 1, count = 0;
  };
  Values find(std::uint32_t tag) const;
  /// An integer.
  std::uint32_t value(const Values& values, std::size_t index) const;
  /// An integer or rational; nothing where the denominator is 0.
  std::optional<double> number(const Values& values, std::size_t index) const;

  std::optional<std::uint32_t> first(std::uint32_t tag) const;
  std::optional<double> first_number(std::uint32_t tag) const;
  /// Printable text, without spaces around it.
  std::string text(std::uint32_t tag) const;
  /// The directory that a tag points to; an empty one where there is none.
  TiffDirectory sub_directory(std::uint32_t tag) const;

 private:
  TiffDirectory(std::span<const std::uint8_t> file, bool little, std::size_t begin);
  std::uint32_t read(std::size_t at, std::size_t size) const;

  std::span<const std::uint8_t> bytes_;
  bool little_ = false;
  std::size_t begin_ = 0, count_ = 0;
};

/// Exif 2.32 (CIPA DC-008).
struct Exif {
  int orientation = 1;       ///< of the stored image: 1 upright … 8, as TIFF 6.0 defines it
  std::string camera;        ///< make and model
  double focal_mm = 0;       ///< 0: not known
  double focal_35mm = 0;     ///< of a full-frame camera with the same field of view; 0: not known
  double pixels_per_mm = 0;  ///< on the sensor; 0: not known
  double sensor_width = 0;   ///< pixels of the image that pixels_per_mm is for; 0: not known
  std::optional<glm::dvec3> position;  ///< GPS: degrees north, degrees east, metres up

  /// Focal length in pixels of an image of that size; 0: not known, or not that of any camera.
  double focal_pixels(int width, int height) const;
};

/// Sets the orientation of a TIFF file to upright, if it has one.
void remove_orientation(std::span<std::uint8_t> tiff);

/// Exif data, which are a TIFF file, from their byte order mark on.
Exif parse_exif(std::span<const std::uint8_t> tiff);

}  // namespace fluxgs
