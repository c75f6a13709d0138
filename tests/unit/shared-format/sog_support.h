// Hand-made SOG scenes for the tests: WebP images, meta.json, and ZIP archives byte by byte.
#pragma once

#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/sog.h"
#include "support.h"

namespace fluxgs::test {

using nlohmann::json;
using Pixel = std::array<std::uint8_t, 4>;
using Files = std::map<std::string, Bytes>;  // name → content

/// A WebP image, with the colours of transparent pixels kept.
inline Bytes webp(const std::vector<Pixel>& pixels, int width, int height, bool lossless = true) {
  WebPConfig config;
  WebPPicture image;
  WebPMemoryWriter writer;
  if (!WebPConfigInit(&config) || !WebPPictureInit(&image)) throw std::runtime_error("webp");
  WebPMemoryWriterInit(&writer);
  config.lossless = lossless;
  config.exact = 1;
  config.method = 0;
  image.use_argb = 1;
  image.width = width;
  image.height = height;
  image.writer = WebPMemoryWrite;
  image.custom_ptr = &writer;
  std::vector<Pixel> padded = pixels;
  padded.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const bool done =
      WebPPictureImportRGBA(&image, padded[0].data(), 4 * width) && WebPEncode(&config, &image);
  Bytes bytes(writer.size);
  if (done) std::memcpy(bytes.data(), writer.mem, writer.size);
  WebPPictureFree(&image);
  WebPMemoryWriterClear(&writer);
  if (!done) throw std::runtime_error("webp");
  return bytes;
}

/// Eight pixels a row; the last row may have pixels that stand for no splat.
inline Bytes webp(const std::vector<Pixel>& pixels) {
  return webp(pixels, 8, std::max(1, static_cast<int>((pixels.size() + 7) / 8)));
}

inline json meta_of(const Files& files) { return json::parse(text_of(files.at("meta.json"))); }
inline void set_meta(Files& files, const json& meta) { files["meta.json"] = bytes_of(meta.dump()); }

/// 256 even steps.
struct Steps {
  double low = 0, high = 0;

  std::uint8_t nearest(double value) const {
    if (high <= low) return 0;
    return static_cast<std::uint8_t>(std::lround((value - low) / (high - low) * 255));
  }
  json codebook() const {
    json list = json::array();
    for (int i = 0; i < 256; ++i) list.push_back(low + (high - low) * i / 255);
    return list;
  }
  double half_step() const { return (high - low) / 510; }
};

inline Steps steps_of(const std::vector<glm::vec3>& values) {
  Steps steps{values[0].x, values[0].x};
  for (const glm::vec3& v : values) {
    for (int c = 0; c < 3; ++c) {
      steps.low = std::min<double>(steps.low, v[c]);
      steps.high = std::max<double>(steps.high, v[c]);
    }
  }
  return steps;
}

inline double symmetric_log(double x) { return std::copysign(std::log1p(std::abs(x)), x); }

inline Pixel pixel_of(const Steps& steps, const glm::vec3& v, std::uint8_t alpha = 255) {
  return {steps.nearest(v.x), steps.nearest(v.y), steps.nearest(v.z), alpha};
}

inline Pixel quat_pixel(glm::quat q) {
  q = glm::normalize(q);
  std::array<float, 4> c{q.w, q.x, q.y, q.z};
  const auto largest = static_cast<std::size_t>(
      std::ranges::max_element(c, {}, [](float v) { return std::abs(v); }) - c.begin());
  Pixel pixel{0, 0, 0, static_cast<std::uint8_t>(252 + largest)};
  for (std::size_t i = 0, to = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double v = c[largest] < 0 ? -c[i] : c[i];
    pixel[to++] = static_cast<std::uint8_t>(std::lround(255 * (v * std::sqrt(2.0) / 2 + 0.5)));
  }
  return pixel;
}

/// Version 2, nearest steps, one palette entry for each splat.
inline Files make_sog(const SplatCloud& cloud) {
  Files files;
  json meta = {{"version", 2}, {"count", cloud.size()}};
  std::vector<Pixel> low, high, scales, quats, colours;
  json mins, maxs;
  for (int c = 0; c < 3; ++c) {
    double from = 1e30, to = -1e30;
    for (const glm::vec3& p : cloud.positions) {
      from = std::min(from, symmetric_log(p[c]));
      to = std::max(to, symmetric_log(p[c]));
    }
    mins.push_back(from);
    maxs.push_back(to);
  }
  const Steps scale_steps = steps_of(cloud.log_scales), dc_steps = steps_of(cloud.sh_dc);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Pixel l{0, 0, 0, 255}, h{0, 0, 0, 255};
    for (std::size_t c = 0; c < 3; ++c) {
      const double from = mins[c], to = maxs[c];
      const double t =
          (symmetric_log(cloud.positions[i][static_cast<int>(c)]) - from) / (to - from);
      const auto q = static_cast<unsigned>(std::lround(65535 * t));
      l[c] = static_cast<std::uint8_t>(q & 255);
      h[c] = static_cast<std::uint8_t>(q >> 8);
    }
    low.push_back(l);
    high.push_back(h);
    scales.push_back(pixel_of(scale_steps, cloud.log_scales[i]));
    quats.push_back(quat_pixel(cloud.rotations[i]));
    const double opacity = 1 / (1 + std::exp(-double{cloud.opacity_logits[i]}));
    colours.push_back(
        pixel_of(dc_steps, cloud.sh_dc[i], static_cast<std::uint8_t>(std::lround(255 * opacity))));
  }
  meta["means"] = {{"mins", mins}, {"maxs", maxs}, {"files", {"means_l.webp", "means_u.webp"}}};
  meta["scales"] = {{"codebook", scale_steps.codebook()}, {"files", {"scales.webp"}}};
  meta["quats"] = {{"files", {"quats.webp"}}};
  meta["sh0"] = {{"codebook", dc_steps.codebook()}, {"files", {"sh0.webp"}}};
  files["means_l.webp"] = webp(low);
  files["means_u.webp"] = webp(high);
  files["scales.webp"] = webp(scales);
  files["quats.webp"] = webp(quats);
  files["sh0.webp"] = webp(colours);
  if (cloud.sh_degree > 0) {
    const int rest = sh_rest_count(cloud.sh_degree);
    const Steps steps = steps_of(cloud.sh_rest);
    std::vector<Pixel> labels, palette;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      labels.push_back(
          {static_cast<std::uint8_t>(i & 255), static_cast<std::uint8_t>(i >> 8), 0, 255});
    }
    for (const glm::vec3& v : cloud.sh_rest) palette.push_back(pixel_of(steps, v));
    meta["shN"] = {{"count", cloud.size()},
                   {"bands", cloud.sh_degree},
                   {"codebook", steps.codebook()},
                   {"files", {"shN_centroids.webp", "shN_labels.webp"}}};
    files["shN_labels.webp"] = webp(labels);
    files["shN_centroids.webp"] =
        webp(palette, 64 * rest, static_cast<int>((cloud.size() + 63) / 64));
  }
  set_meta(files, meta);
  return files;
}

inline void write_files(const TemporaryFolder& folder, const Files& files,
                        const std::string& below = "") {
  if (!below.empty()) std::filesystem::create_directories(folder / below);
  for (const auto& [name, bytes] : files) {
    ASSERT_TRUE(write_file_atomic(folder / (below + name), bytes));
  }
}

/// An entry of a ZIP archive (APPNOTE 4.3), each field as the test wants it.
struct ZipEntry {
  std::string name;
  Bytes data;  ///< as it lies in the archive
  std::uint32_t size = 0, packed_size = 0, crc = 0;
  std::uint16_t method = 0, flags = 0;
};

inline std::uint32_t crc_of(const Bytes& bytes) {
  std::uint32_t crc = ~0u;
  for (const std::byte b : bytes) {
    crc ^= static_cast<std::uint32_t>(b);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

inline ZipEntry stored(const std::string& name, const Bytes& data) {
  const auto size = static_cast<std::uint32_t>(data.size());
  return {name, data, size, size, crc_of(data), 0, 0};
}

inline Bytes zip_of(const std::vector<ZipEntry>& entries) {
  Bytes zip, directory;
  const auto put = [](Bytes& to, const std::string& raw) {
    const Bytes bytes = bytes_of(raw);
    to.insert(to.end(), bytes.begin(), bytes.end());
  };
  for (const ZipEntry& e : entries) {
    Bytes common;  // of the local header and of the directory
    for (const std::uint16_t v :
         {std::uint16_t{20}, e.flags, e.method, std::uint16_t{0}, std::uint16_t{33}})
      append(common, v);
    for (const std::uint32_t v : {e.crc, e.packed_size, e.size}) append(common, v);
    append(common, static_cast<std::uint16_t>(e.name.size()));
    append(common, std::uint16_t{0});
    const auto offset = static_cast<std::uint32_t>(zip.size());
    put(zip, "PK\x03\x04");
    zip.insert(zip.end(), common.begin(), common.end());
    put(zip, e.name);
    zip.insert(zip.end(), e.data.begin(), e.data.end());
    put(directory, std::string("PK\x01\x02\x14\x00", 6));
    directory.insert(directory.end(), common.begin(), common.end());
    directory.resize(directory.size() + 10);  // no comment, disk 0, no attributes
    append(directory, offset);
    put(directory, e.name);
  }
  const auto start = static_cast<std::uint32_t>(zip.size());
  zip.insert(zip.end(), directory.begin(), directory.end());
  put(zip, std::string("PK\x05\x06\0\0\0\0", 8));
  append(zip, static_cast<std::uint16_t>(entries.size()));
  append(zip, static_cast<std::uint16_t>(entries.size()));
  append(zip, static_cast<std::uint32_t>(directory.size()));
  append(zip, start);
  append(zip, std::uint16_t{0});
  return zip;
}

/// The archive with a 64-bit end of its directory (APPNOTE 4.3.14), the plain one saying "see
/// there".
inline Bytes in_zip64(Bytes zip) {
  const std::size_t end = zip.size() - 22;
  const auto load = [&](std::size_t at, auto value) {
    std::memcpy(&value, zip.data() + at, sizeof value);
    return value;
  };
  const std::uint64_t count = load(end + 10, std::uint16_t{}),
                      size = load(end + 12, std::uint32_t{}),
                      start = load(end + 16, std::uint32_t{});
  Bytes more = bytes_of("PK\x06\x06");
  append(more, std::uint64_t{44});
  append(more, std::uint16_t{45});
  append(more, std::uint16_t{45});
  append(more, std::uint64_t{0});  // disks
  for (const std::uint64_t v : {count, count, size, start}) append(more, v);
  const Bytes locator = bytes_of("PK\x06\x07");
  more.insert(more.end(), locator.begin(), locator.end());
  append(more, std::uint32_t{0});
  append(more, std::uint64_t{end});
  append(more, std::uint32_t{1});
  std::fill(zip.begin() + std::ptrdiff_t(end) + 8, zip.begin() + std::ptrdiff_t(end) + 20,
            std::byte{0xff});
  zip.insert(zip.begin() + std::ptrdiff_t(end), more.begin(), more.end());
  return zip;
}

inline std::vector<ZipEntry> entries_of(const Files& files) {
  std::vector<ZipEntry> entries;
  for (const auto& [name, bytes] : files) entries.push_back(stored(name, bytes));
  return entries;
}

inline Bytes bundle(const Files& files) { return zip_of(entries_of(files)); }

inline Expected<SceneFile> read_bundle(const Files& files) {
  return read_sog(bundle(files), "test.sog");
}

}  // namespace fluxgs::test
