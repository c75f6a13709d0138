#include "io/sog/sog_decode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <fmt/format.h>

#include "io/sog/webp_image.h"
#include "io/whole_cloud.h"

namespace fluxgs::io {
namespace {

constexpr std::uint64_t kMaxImageBytes = std::uint64_t(1) << 30;
constexpr std::size_t kPixelsPerSplat = 4, kPixelSlack = std::size_t(1) << 20;
constexpr int kFirstMode = 252;                               // of a quaternion, section 3.2
constexpr std::size_t kPaletteRow = 64, kPaletteRows = 1024;  // section 3.5

// Decodes the images of one scene, and of them splat by splat.
class SogDecoder {
 public:
  SogDecoder(const SogMeta& meta, const NamedFiles& files, const std::string& folder,
             const std::string& name)
      : meta_(meta), files_(files), folder_(folder), name_(name) {}

  Expected<void> decode(SplatSink& sink, SceneFile& scene) {
    if (auto done = read_means(); !done) return done;
    if (meta_.sh)
      if (auto done = load_palette(*meta_.sh); !done) return done;
    const ComingSplats coming{.count = meta_.count, .sh_degree = degree_, .held = held()};
    const auto wanted = sink.begin(coming);
    if (!wanted) return std::unexpected(wanted.error());
    for (const auto step :
         {&SogDecoder::load_positions, &SogDecoder::load_rotations, &SogDecoder::load_scales,
          &SogDecoder::load_colours, &SogDecoder::load_labels}) {
      if (auto done = (this->*step)(); !done) return done;
    }
    scene.cloud.filter = meta_.filter;
    return hand_on(coming, *wanted, name_, sink, scene,
                   [&](std::size_t first, SplatCloud& part) -> Expected<void> {
                     fill_part(first, part);
                     return {};
                   });
  }

 private:
  using Bytes = std::vector<std::byte>;

  std::unexpected<Error> bad(const std::string& image, std::string what) const {
    return fail(name_, folder_ + image, std::move(what));
  }

  Expected<Bytes> read(const std::string& image) const {
    return files_(folder_ + image, kMaxImageBytes);
  }

  Expected<void> decode_image(const Bytes& bytes, const std::string& file, RgbaImage& image) const {
    auto decoded = decode_webp(bytes, std::max<std::size_t>(meta_.count, 1),
                               kPixelSlack + kPixelsPerSplat * meta_.count, name_, folder_ + file);
    if (!decoded) return std::unexpected(decoded.error());
    image = std::move(*decoded);
    return {};
  }

  Expected<void> load(const std::string& file, RgbaImage& image) const {
    const auto bytes = read(file);
    if (!bytes) return std::unexpected(bytes.error());
    return decode_image(*bytes, file, image);
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

  Expected<void> read_means() {
    for (std::size_t i = 0; i < means_.size(); ++i) {
      auto bytes = read(meta_.means[i]);
      if (!bytes) return std::unexpected(bytes.error());
      means_[i] = std::move(*bytes);
    }
    const std::size_t size = means_[0].size() + means_[1].size(), most = max_sog_splats(size);
    if (meta_.count <= most) return {};
    return bad(meta_.means[0],
               fmt::format("holds, with {}, {} bytes; expected at most {} splats of them, not {}",
                           meta_.means[1], size, most, meta_.count));
  }

  Expected<void> load_positions() {
    if (auto done = decode_image(means_[0], meta_.means[0], low_); !done) return done;
    auto done = decode_image(means_[1], meta_.means[1], high_);
    means_ = {};
    return done;
  }

  Expected<void> load_rotations() {
    if (auto done = load(meta_.quats_image, rotations_); !done) return done;
    for (std::size_t i = 0; i < meta_.count; ++i) {
      if (rotations_(i, 3) >= kFirstMode) continue;
      return bad(meta_.quats_image,
                 fmt::format("pixel {} has the mode {}; expected 252 to 255", i, rotations_(i, 3)));
    }
    return {};
  }

  Expected<void> load_scales() {
    if (auto done = load(meta_.scales_image, scales_); !done) return done;
    for (std::size_t c = 0; c < 3; ++c)
      if (auto ok = check_bytes(scales_, meta_.count, c, meta_.scales[c], meta_.scales_image); !ok)
        return ok;
    return {};
  }

  Expected<void> load_colours() {
    if (auto done = load(meta_.sh0_image, colours_); !done) return done;
    for (std::size_t c = 0; c < 3; ++c)
      if (auto ok = check_bytes(colours_, meta_.count, c, meta_.sh0[c], meta_.sh0_image); !ok)
        return ok;
    return {};
  }

  Expected<void> load_labels() {
    if (!meta_.sh) return {};
    if (auto done = load(meta_.sh->labels, labels_); !done) return done;
    const std::size_t entries = palette_.size() / static_cast<std::size_t>(sh_rest_count(degree_));
    for (std::size_t i = 0; i < meta_.count; ++i) {
      if (label(i) < entries) continue;
      return bad(meta_.sh->labels,
                 fmt::format("pixel {} has the label {}, but the palette has {} entries", i,
                             label(i), entries));
    }
    return {};
  }

  std::size_t label(std::size_t i) const {
    return labels_(i, 0) + std::size_t(256) * labels_(i, 1);
  }

  // Section 3.5. The entries one after the other, and their degree. The image has 64 entries in a
  // row, so that row after row they are one after the other, too.
  Expected<void> load_palette(const SogSh& sh) {
    const auto bytes = read(sh.centroids);
    if (!bytes) return std::unexpected(bytes.error());
    const std::size_t widest = kPaletteRow * static_cast<std::size_t>(sh_rest_count(3));
    const auto image = decode_webp(*bytes, 1, widest * kPaletteRows, name_, folder_ + sh.centroids);
    if (!image) return std::unexpected(image.error());
    const auto degree = palette_degree(*image, sh);
    if (!degree) return std::unexpected(degree.error());
    degree_ = *degree;
    const auto rest = static_cast<std::size_t>(sh_rest_count(*degree));
    const std::size_t held = kPaletteRow * image->height, entries = sh.count.value_or(held);
    if (entries > held) {
      return bad(sh.centroids, fmt::format("holds {} entries; expected {}", held, entries));
    }
    palette_.resize(entries * rest);
    for (std::size_t c = 0; c < 3; ++c) {
      if (auto ok = check_bytes(*image, palette_.size(), c, sh.table, sh.centroids); !ok) return ok;
      for (std::size_t i = 0; i < palette_.size(); ++i) {
        palette_[i][static_cast<int>(c)] = sh.table.values[(*image)(i, c)];
      }
    }
    return {};
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

  // The images of most scenes have a pixel a splat.
  std::uint64_t held() const {
    const std::uint64_t images = meta_.sh ? 6 : 5;
    return 4 * images * meta_.count + sizeof(glm::vec3) * palette_.size();
  }

  // Section 3.1.
  glm::vec3 position(std::size_t i) const {
    glm::vec3 result;
    for (int axis = 0; axis < 3; ++axis) {
      const double from = meta_.mean_min[axis], step = (meta_.mean_max[axis] - from) / 65535;
      const auto channel = static_cast<std::size_t>(axis);
      const double n = from + step * (low_(i, channel) + 256 * high_(i, channel));
      result[axis] = static_cast<float>(std::copysign(std::expm1(std::abs(n)), n));
    }
    return result;
  }

  // Section 3.2: three components of w, x, y, z; the mode names the fourth, which is the largest.
  glm::quat rotation(std::size_t i) const {
    const int mode = rotations_(i, 3) - kFirstMode;
    double wxyz[4], squares = 0;
    for (int c = 0, from = 0; c < 4; ++c) {
      if (c == mode) continue;
      const double stored = rotations_(i, static_cast<std::size_t>(from++)) / 255.0;
      wxyz[c] = (2 * stored - 1) / std::numbers::sqrt2;
      squares += wxyz[c] * wxyz[c];
    }
    wxyz[mode] = std::sqrt(std::max(0.0, 1 - squares));
    return glm::quat(glm::dquat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]));
  }

  // The splats from `first` on. Sections 3.3 and 3.4 are tables of scales, and of colours and
  // opacities.
  void fill_part(std::size_t first, SplatCloud& part) const {
    const auto stored = static_cast<std::size_t>(sh_rest_count(degree_));
    const auto rest = static_cast<std::size_t>(sh_rest_count(part.sh_degree));
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::size_t i = first + k;
      part.positions[k] = position(i);
      part.rotations[k] = rotation(i);
      for (std::size_t c = 0; c < 3; ++c) {
        part.log_scales[k][static_cast<int>(c)] = meta_.scales[c].values[scales_(i, c)];
        part.sh_dc[k][static_cast<int>(c)] = meta_.sh0[c].values[colours_(i, c)];
      }
      part.opacity_logits[k] = meta_.sh0[3].values[colours_(i, 3)];
      if (rest > 0)
        std::copy_n(palette_.data() + label(i) * stored, rest, part.sh_rest.data() + k * rest);
    }
  }

  const SogMeta& meta_;
  const NamedFiles& files_;
  const std::string& folder_;
  const std::string& name_;
  std::array<Bytes, 2> means_;  // as read, until they are decoded
  RgbaImage low_, high_, rotations_, scales_, colours_, labels_;
  std::vector<glm::vec3> palette_;
  int degree_ = 0;
};

}  // namespace

Expected<void> decode_sog(const SogMeta& meta, const NamedFiles& files, const std::string& folder,
                          const std::string& name, SplatSink& sink, SceneFile& scene) {
  return SogDecoder(meta, files, folder, name).decode(sink, scene);
}

}  // namespace fluxgs::io
