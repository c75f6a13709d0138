#include "io/sog/sog_decode.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"
#include "io/sog/webp_image.h"

namespace fluxgs::io {
namespace {

constexpr std::uint64_t kMaxImageBytes = std::uint64_t(1) << 30;
constexpr std::size_t kPixelsPerSplat = 4, kPixelSlack = std::size_t(1) << 20;
constexpr std::size_t kPaletteRow = 64, kPaletteRows = 1024;  // section 3.5

// Decodes the images of one scene, each into its arrays of the cloud.
class SogDecoder {
 public:
  SogDecoder(const SogMeta& meta, const NamedFiles& files, const std::string& folder,
             const std::string& name)
      : meta_(meta), files_(files), folder_(folder), name_(name) {}

  Expected<SplatCloud> decode() {
    for (const auto step : {&SogDecoder::positions, &SogDecoder::rotations, &SogDecoder::scales,
                            &SogDecoder::colours, &SogDecoder::sh}) {
      if (auto done = (this->*step)(); !done) return std::unexpected(done.error());
    }
    return std::move(cloud_);
  }

 private:
  using Bytes = std::vector<std::byte>;

  std::unexpected<Error> bad(const std::string& image, std::string what) const {
    return fail(name_, folder_ + image, std::move(what));
  }

  Expected<Bytes> read(const std::string& image) const {
    return files_(folder_ + image, kMaxImageBytes);
  }

  Expected<RgbaImage> decode_image(const Bytes& bytes, const std::string& image) const {
    return decode_webp(bytes, std::max<std::size_t>(meta_.count, 1),
                       kPixelSlack + kPixelsPerSplat * meta_.count, name_, folder_ + image);
  }

  Expected<RgbaImage> load(const std::string& image) const {
    const auto bytes = read(image);
    if (!bytes) return std::unexpected(bytes.error());
    return decode_image(*bytes, image);
  }

  // That the first `count` pixels have no byte beyond a table that is shorter than 256.
  Expected<void> check_bytes(const RgbaImage& image, std::size_t count, std::size_t channel,
                             const SogTable& table, const std::string& file) const {
    if (table.size == table.values.size()) return {};
    for (std::size_t i = 0; i < count; ++i) {
      if (image(i, channel) < table.size) continue;
      return bad(file, fmt::format("pixel {} has the index {}, but the codebook has {} values", i,
                                   image(i, channel), table.size));
    }
    return {};
  }

  // Section 3.1.
  Expected<void> positions() {
    const auto low_bytes = read(meta_.means[0]);
    if (!low_bytes) return std::unexpected(low_bytes.error());
    const auto high_bytes = read(meta_.means[1]);
    if (!high_bytes) return std::unexpected(high_bytes.error());
    const std::size_t most = max_sog_splats(low_bytes->size() + high_bytes->size());
    if (meta_.count > most) {
      return bad(
          meta_.means[0],
          fmt::format("holds, with {}, {} bytes; expected at most {} splats of them, not {}",
                      meta_.means[1], low_bytes->size() + high_bytes->size(), most, meta_.count));
    }
    const auto low = decode_image(*low_bytes, meta_.means[0]);
    if (!low) return std::unexpected(low.error());
    const auto high = decode_image(*high_bytes, meta_.means[1]);
    if (!high) return std::unexpected(high.error());
    auto cloud = allocate_cloud(meta_.count, 0, name_);
    if (!cloud) return std::unexpected(cloud.error());
    cloud_ = std::move(*cloud);
    cloud_.filter = meta_.filter;
    for (int axis = 0; axis < 3; ++axis) {
      const double from = meta_.mean_min[axis], step = (meta_.mean_max[axis] - from) / 65535;
      const auto channel = static_cast<std::size_t>(axis);
      for (std::size_t i = 0; i < meta_.count; ++i) {
        const double n = from + step * ((*low)(i, channel) + 256 * (*high)(i, channel));
        cloud_.positions[i][axis] = static_cast<float>(std::copysign(std::expm1(std::abs(n)), n));
      }
    }
    return {};
  }

  // Section 3.2: three components of w, x, y, z; the mode names the fourth, which is the largest.
  Expected<void> rotations() {
    const auto image = load(meta_.quats_image);
    if (!image) return std::unexpected(image.error());
    for (std::size_t i = 0; i < meta_.count; ++i) {
      const int mode = (*image)(i, 3) - 252;
      if (mode < 0) {
        return bad(meta_.quats_image,
                   fmt::format("pixel {} has the mode {}; expected 252 to 255", i, mode + 252));
      }
      double wxyz[4], squares = 0;
      for (int c = 0, from = 0; c < 4; ++c) {
        if (c == mode) continue;
        const double stored = (*image)(i, static_cast<std::size_t>(from++)) / 255.0;
        wxyz[c] = (2 * stored - 1) / std::numbers::sqrt2;
        squares += wxyz[c] * wxyz[c];
      }
      wxyz[mode] = std::sqrt(std::max(0.0, 1 - squares));
      cloud_.rotations[i] = glm::quat(glm::dquat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]));
    }
    return {};
  }

  // Section 3.3.
  Expected<void> scales() {
    const auto image = load(meta_.scales_image);
    if (!image) return std::unexpected(image.error());
    for (std::size_t c = 0; c < 3; ++c) {
      const SogTable& table = meta_.scales[c];
      if (auto ok = check_bytes(*image, meta_.count, c, table, meta_.scales_image); !ok) return ok;
      for (std::size_t i = 0; i < meta_.count; ++i) {
        cloud_.log_scales[i][static_cast<int>(c)] = table.values[(*image)(i, c)];
      }
    }
    return {};
  }

  // Section 3.4.
  Expected<void> colours() {
    const auto image = load(meta_.sh0_image);
    if (!image) return std::unexpected(image.error());
    for (std::size_t c = 0; c < 3; ++c) {
      const SogTable& table = meta_.sh0[c];
      if (auto ok = check_bytes(*image, meta_.count, c, table, meta_.sh0_image); !ok) return ok;
      for (std::size_t i = 0; i < meta_.count; ++i) {
        cloud_.sh_dc[i][static_cast<int>(c)] = table.values[(*image)(i, c)];
      }
    }
    for (std::size_t i = 0; i < meta_.count; ++i) {
      cloud_.opacity_logits[i] = meta_.sh0[3].values[(*image)(i, 3)];
    }
    return {};
  }

  // Section 3.5.
  Expected<void> sh() {
    if (!meta_.sh) return {};
    const auto palette = load_palette(*meta_.sh);
    if (!palette) return std::unexpected(palette.error());
    const auto labels = load(meta_.sh->labels);
    if (!labels) return std::unexpected(labels.error());
    const auto rest = static_cast<std::size_t>(sh_rest_count(cloud_.sh_degree));
    const std::size_t entries = palette->size() / rest;
    cloud_.sh_rest.resize(meta_.count * rest);
    for (std::size_t i = 0; i < meta_.count; ++i) {
      const std::size_t label = (*labels)(i, 0) + std::size_t(256) * (*labels)(i, 1);
      if (label >= entries) {
        return bad(meta_.sh->labels,
                   fmt::format("pixel {} has the label {}, but the palette has {} entries", i,
                               label, entries));
      }
      std::copy_n(palette->begin() + static_cast<std::ptrdiff_t>(label * rest), rest,
                  cloud_.sh_rest.begin() + static_cast<std::ptrdiff_t>(i * rest));
    }
    return {};
  }

  // The entries one after the other; sets the degree of the cloud. The image has 64 entries in a
  // row, so that row after row they are one after the other, too.
  Expected<std::vector<glm::vec3>> load_palette(const SogSh& sh) {
    const auto bytes = read(sh.centroids);
    if (!bytes) return std::unexpected(bytes.error());
    const std::size_t widest = kPaletteRow * static_cast<std::size_t>(sh_rest_count(3));
    const auto image = decode_webp(*bytes, 1, widest * kPaletteRows, name_, folder_ + sh.centroids);
    if (!image) return std::unexpected(image.error());
    const auto degree = palette_degree(*image, sh);
    if (!degree) return std::unexpected(degree.error());
    cloud_.sh_degree = *degree;
    const auto rest = static_cast<std::size_t>(sh_rest_count(*degree));
    const std::size_t held = kPaletteRow * image->height, entries = sh.count.value_or(held);
    if (entries > held) {
      return bad(sh.centroids, fmt::format("holds {} entries; expected {}", held, entries));
    }
    std::vector<glm::vec3> palette(entries * rest);
    for (std::size_t c = 0; c < 3; ++c) {
      if (auto ok = check_bytes(*image, palette.size(), c, sh.table, sh.centroids); !ok) {
        return std::unexpected(ok.error());
      }
      for (std::size_t i = 0; i < palette.size(); ++i) {
        palette[i][static_cast<int>(c)] = sh.table.values[(*image)(i, c)];
      }
    }
    return palette;
  }

  Expected<int> palette_degree(const RgbaImage& image, const SogSh& sh) const {
    for (int degree = 1; degree <= 3; ++degree) {
      if (sh.degree.value_or(degree) != degree) continue;
      if (image.width == kPaletteRow * static_cast<std::size_t>(sh_rest_count(degree))) {
        return degree;
      }
    }
    const std::string wanted =
        sh.degree ? fmt::format("{} for degree {}", 64 * sh_rest_count(*sh.degree), *sh.degree)
                  : "192, 512 or 960";
    return bad(sh.centroids, fmt::format("is {} pixels wide; expected {}", image.width, wanted));
  }

  const SogMeta& meta_;
  const NamedFiles& files_;
  const std::string& folder_;
  const std::string& name_;
  SplatCloud cloud_;
};

}  // namespace

Expected<SplatCloud> decode_sog(const SogMeta& meta, const NamedFiles& files,
                                const std::string& folder, const std::string& name) {
  return SogDecoder(meta, files, folder, name).decode();
}

}  // namespace fluxgs::io
