// Exif data made by hand, and image files that carry them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace fluxgs::test {

/// A TIFF file of one directory, with an Exif and a GPS directory inside of it.
class TiffWriter {
 public:
  explicit TiffWriter(bool little = true) : little_(little) {}

  struct Entry {
    std::uint32_t tag, type, count;
    std::string values;
  };
  Entry shorts(std::uint32_t tag, std::uint32_t value) const {
    return {tag, 3, 1, number(value, 2)};
  }
  Entry text(std::uint32_t tag, const std::string& text) const {
    return {tag, 2, static_cast<std::uint32_t>(text.size() + 1), text + '\0'};
  }
  Entry rationals(std::uint32_t tag,
                  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& values) const {
    std::string bytes;
    for (const auto& [a, b] : values) bytes += number(a, 4) + number(b, 4);
    return {tag, 5, static_cast<std::uint32_t>(values.size()), bytes};
  }

  /// `main` first; the other two where they are not empty.
  std::string file(std::vector<Entry> main, const std::vector<Entry>& exif,
                   const std::vector<Entry>& gps) const {
    const std::size_t links = (exif.empty() ? 0 : 1) + (gps.empty() ? 0 : 1);
    std::size_t at = 8 + size_of(main) + 12 * links;
    for (const auto& [tag, entries] : {std::pair(34665, &exif), std::pair(34853, &gps)}) {
      if (entries->empty()) continue;
      main.push_back(
          {static_cast<std::uint32_t>(tag), 4, 1, number(static_cast<std::uint32_t>(at), 4)});
      at += size_of(*entries);
    }
    std::string bytes = (little_ ? "II" : "MM") + number(42, 2) + number(8, 4);
    for (const auto* entries : {&std::as_const(main), &exif, &gps})
      if (!entries->empty()) bytes += directory(*entries, bytes.size());
    return bytes;
  }

  std::string number(std::uint32_t value, int bytes) const {
    std::string text;
    for (int i = 0; i < bytes; ++i)
      text += static_cast<char>(value >> 8 * (little_ ? i : bytes - 1 - i));
    return text;
  }

 private:
  static std::size_t size_of(const std::vector<Entry>& entries) {
    std::size_t size = 2 + 12 * entries.size() + 4;
    for (const Entry& e : entries) size += e.values.size() > 4 ? e.values.size() : 0;
    return size;
  }
  std::string directory(const std::vector<Entry>& entries, std::size_t at) const {
    std::string bytes = number(static_cast<std::uint32_t>(entries.size()), 2), behind;
    const std::size_t end = at + 2 + 12 * entries.size() + 4;
    for (const Entry& e : entries) {
      bytes += number(e.tag, 2) + number(e.type, 2) + number(e.count, 4);
      std::string inside = e.values;
      if (inside.size() > 4) {
        inside = number(static_cast<std::uint32_t>(end + behind.size()), 4);
        behind += e.values;
      }
      inside.resize(4);
      bytes += inside;
    }
    return bytes + number(0, 4) + behind;
  }
  bool little_;
};

/// Only an orientation.
inline std::string orientation_tiff(int orientation, bool little = true) {
  const TiffWriter writer(little);
  return writer.file({writer.shorts(274, static_cast<std::uint32_t>(orientation))}, {}, {});
}

/// A JPEG with an Exif segment behind its first marker.
inline std::string jpeg_with_exif(const std::string& jpeg, const std::string& tiff) {
  const std::string body = std::string("Exif\0\0", 6) + tiff;
  std::string segment = "\xff\xe1";
  segment += static_cast<char>((body.size() + 2) >> 8);
  segment += static_cast<char>(body.size() + 2);
  return jpeg.substr(0, 2) + segment + body + jpeg.substr(2);
}

/// A PNG with an eXIf chunk behind its header.
inline std::string png_with_exif(const std::string& png, const std::string& tiff) {
  const TiffWriter big(false);
  const std::string chunk = "eXIf" + tiff;
  std::uint32_t crc = ~0U;  // ISO 3309
  for (const char c : chunk) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320 : crc >> 1;
  }
  constexpr std::size_t kHeaderEnd = 8 + 25;
  return png.substr(0, kHeaderEnd) + big.number(static_cast<std::uint32_t>(tiff.size()), 4) +
         chunk + big.number(~crc, 4) + png.substr(kHeaderEnd);
}

}  // namespace fluxgs::test
