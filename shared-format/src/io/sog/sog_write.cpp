#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "fluxgs/io/sog.h"
#include "io/sog/scalar_codebook.h"
#include "io/sog/sh_palette.h"
#include "io/sog/sog_decode.h"
#include "io/sog/webp_image.h"
#include "io/sog/zip_writer.h"
#include "io/splat/smallest_three.h"
#include "io/splat/spatial_order.h"

namespace fluxgs {
namespace {

using namespace io;
using nlohmann::json;
using Bytes = std::vector<std::byte>;
using Pixel = std::array<std::uint8_t, 4>;

constexpr std::size_t kPaletteRow = 64, kMostPalette = 65536;

// Beyond any scene; so far, rounding leaves values finite and their squares are floats.
constexpr double kMostPosition = 1e38;
constexpr float kMostSh = 1000;

// Parts of the time, measured on scenes of degree 3: the first images, up to the palette's end.
constexpr double kFirstTime = 0.25, kPaletteEnd = 0.75;

// As many entries as other writers have: a power of two that is at most half of the splats.
std::size_t palette_size(std::size_t splats) {
  if (splats <= 1024) return splats;
  return std::min(kMostPalette, std::bit_floor(splats));
}

// About square, sides of whole blocks of four.
RgbaImage image_for(std::size_t splats) {
  const auto whole = [](double side) {
    return 4 * std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(side / 4)));
  };
  RgbaImage image;
  image.width = whole(std::sqrt(static_cast<double>(splats)));
  image.height = whole(static_cast<double>(splats) / static_cast<double>(image.width));
  image.bytes.resize(4 * image.pixels());
  return image;
}

// The area that a splat is drawn on from its broad side, times its squared opacity: an error of its
// size is that of so many pixels. A few large splats make up most of an image. They are so rare
// that a codebook without weights has hardly a value for their sizes.
std::vector<float> drawn_areas(const SplatCloud& cloud) {
  std::vector<float> areas(cloud.size());
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const glm::vec3& s = cloud.log_scales[i];
    const double thin = std::min({s.x, s.y, s.z});
    const double area = std::exp(std::clamp(double{s.x} + s.y + s.z - thin, -60.0, 60.0));
    const double opacity = opacity_of(cloud.opacity_logits[i]);
    areas[i] = static_cast<float>(area * opacity * opacity);
  }
  return areas;
}

// The cloud's attributes as images, of which the specification's sections are named below.
class SogEncoder {
 public:
  SogEncoder(const SplatCloud& cloud, const std::string& name, const WriteOptions& options)
      : cloud_(cloud),
        name_(name),
        options_(options),
        order_(spatial_order(cloud.positions)),
        areas_(drawn_areas(cloud)) {}

  Expected<Bytes> encode() {
    meta_["version"] = 2;
    meta_["asset"] = {{"generator", "Flux-GS"}};
    meta_["count"] = cloud_.size();
    if (cloud_.filter.compensated) meta_["antialias"] = true, meta_["model"] = "antialiased";
    if (cloud_.filter.dilation != ScreenFilter{}.dilation)
      meta_["dilation"] = cloud_.filter.dilation;
    files_.emplace_back("meta.json", Bytes());
    for (const auto step : {&SogEncoder::positions, &SogEncoder::rotations, &SogEncoder::scales,
                            &SogEncoder::colours, &SogEncoder::sh})
      if (auto done = (this->*step)(); !done) return std::unexpected(done.error());
    const std::string text = meta_.dump();
    const auto bytes = std::as_bytes(std::span(text));
    files_[0].second.assign(bytes.begin(), bytes.end());
    return write_zip(files_, name_);
  }

 private:
  void progress(double part) const {
    if (options_.progress) options_.progress(part);
  }

  // An image of a pixel for each splat.
  template <class Make>
  Expected<void> add_image(const std::string& file, const Make& make) {
    RgbaImage image = image_for(cloud_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) set_pixel(image, k, make(order_[k]));
    return add_file(file, image);
  }

  static void set_pixel(RgbaImage& image, std::size_t at, const Pixel& pixel) {
    for (std::size_t c = 0; c < pixel.size(); ++c)
      image.bytes[4 * at + c] = static_cast<std::byte>(pixel[c]);
  }

  Expected<void> add_file(const std::string& file, const RgbaImage& image) {
    auto bytes = encode_webp(image, name_, file);
    if (!bytes) return std::unexpected(bytes.error());
    files_.emplace_back(file, std::move(*bytes));
    const auto images = static_cast<double>(files_.size() - 1);  // five before the palette
    if (cloud_.sh_degree == 0)
      progress(images / 5);
    else
      progress(images <= 5 ? kFirstTime * images / 5 : 1 - (1 - kPaletteEnd) * (7 - images) / 2);
    return {};
  }

  // Section 3.1.
  Expected<void> positions() {
    constexpr double kMost = std::numeric_limits<double>::max();
    glm::dvec3 low(kMost), high(-kMost);
    const auto contracted = [&](std::uint32_t i, int c) {
      const double p = cloud_.positions[i][c];
      return std::copysign(std::log1p(std::min(std::abs(p), kMostPosition)), p);
    };
    for (const std::uint32_t i : order_)
      for (int c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], contracted(i, c));
        high[c] = std::max(high[c], contracted(i, c));
      }
    if (order_.empty()) low = high = glm::dvec3(0);
    const auto level = [&](std::uint32_t i, int c) {
      const double range = std::max(high[c] - low[c], 1e-300);
      return static_cast<unsigned>(std::lround(65535 * (contracted(i, c) - low[c]) / range));
    };
    const auto byte = [&](std::uint32_t i, int c, unsigned shift) {
      return static_cast<std::uint8_t>(level(i, c) >> shift);
    };
    const auto bytes = [&](std::uint32_t i, unsigned shift) {
      return Pixel{byte(i, 0, shift), byte(i, 1, shift), byte(i, 2, shift), 255};
    };
    meta_["means"] = {{"mins", {low.x, low.y, low.z}},
                      {"maxs", {high.x, high.y, high.z}},
                      {"files", {"means_l.webp", "means_u.webp"}}};
    if (auto ok = add_image("means_l.webp", [&](auto i) { return bytes(i, 0); }); !ok) return ok;
    if (auto ok = add_image("means_u.webp", [&](auto i) { return bytes(i, 8); }); !ok) return ok;
    return check_size();
  }

  // Limit of read_sog() against bombs, which splats that all lie in few places exceed.
  Expected<void> check_size() const {
    const std::size_t bytes = files_[1].second.size() + files_[2].second.size();
    if (cloud_.size() <= max_sog_splats(bytes)) return {};
    return fail(name_, "splats",
                fmt::format("the positions of all {} take {} bytes, so alike are they; expected a "
                            "scene of more different splats",
                            cloud_.size(), bytes));
  }

  // Section 3.2: three components of w, x, y, z, and which is the fourth, the largest.
  Expected<void> rotations() {
    meta_["quats"] = {{"files", {"quats.webp"}}};
    return add_image("quats.webp", [&](std::uint32_t i) {
      const glm::quat& rotation = cloud_.rotations[i];
      const io::SmallestThree parts =
          io::to_smallest_three({rotation.w, rotation.x, rotation.y, rotation.z}, 0);
      Pixel pixel{0, 0, 0, static_cast<std::uint8_t>(252 + parts.largest)};
      for (std::size_t c = 0; c < parts.others.size(); ++c)
        pixel[c] = byte_of((parts.others[c] * std::numbers::sqrt2 + 1) / 2);
      return pixel;
    });
  }

  // Adds the codebook of an attribute of three numbers to its part of meta.json. Weights: one for
  // each, or none.
  ScalarCodebook add_codebook(const char* group, const std::vector<glm::vec3>& values,
                              const std::vector<float>& weights) {
    std::vector<WeightedNumber> numbers;
    numbers.reserve(3 * values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      for (int c = 0; c < 3; ++c)
        numbers.push_back({values[i][c], weights.empty() ? 1.0F : weights[i]});
    const ScalarCodebook codebook = make_scalar_codebook(std::move(numbers));
    meta_[group]["codebook"] = codebook;
    return codebook;
  }

  static Pixel indices(const ScalarCodebook& codebook, const glm::vec3& v, std::uint8_t alpha) {
    return {nearest_index(codebook, v.x), nearest_index(codebook, v.y),
            nearest_index(codebook, v.z), alpha};
  }

  // Section 3.3.
  Expected<void> scales() {
    const ScalarCodebook codebook = add_codebook("scales", cloud_.log_scales, areas_);
    meta_["scales"]["files"] = {"scales.webp"};
    return add_image("scales.webp",
                     [&](std::uint32_t i) { return indices(codebook, cloud_.log_scales[i], 255); });
  }

  // Section 3.4.
  Expected<void> colours() {
    const ScalarCodebook codebook = add_codebook("sh0", cloud_.sh_dc, {});
    meta_["sh0"]["files"] = {"sh0.webp"};
    return add_image("sh0.webp", [&](std::uint32_t i) {
      return indices(codebook, cloud_.sh_dc[i], byte_of(opacity_of(cloud_.opacity_logits[i])));
    });
  }

  // Section 3.5.
  Expected<void> sh() {
    if (cloud_.sh_degree == 0 || cloud_.size() == 0) return {};
    const auto rest = static_cast<std::size_t>(sh_rest_count(cloud_.sh_degree));
    std::vector<float> vectors;
    vectors.reserve(3 * cloud_.sh_rest.size());
    for (const glm::vec3& v : cloud_.sh_rest)
      for (int c = 0; c < 3; ++c) vectors.push_back(std::clamp(v[c], -kMostSh, kMostSh));
    const ShPalette palette = make_sh_palette(
        vectors, 3 * rest, palette_size(cloud_.size()),
        [&](double part) { progress(kFirstTime + (kPaletteEnd - kFirstTime) * part); });
    std::vector<glm::vec3> entries(palette.entries.size() / 3);
    for (std::size_t k = 0; k < entries.size(); ++k)
      for (int c = 0; c < 3; ++c)
        entries[k][c] = palette.entries[3 * k + static_cast<std::size_t>(c)];
    const ScalarCodebook codebook = add_codebook("shN", entries, {});
    json& group = meta_["shN"];
    group["count"] = entries.size() / rest;
    group["bands"] = cloud_.sh_degree;
    group["files"] = {"shN_centroids.webp", "shN_labels.webp"};
    RgbaImage image;
    image.width = kPaletteRow * rest;
    image.height = (entries.size() + image.width - 1) / image.width;
    image.bytes.resize(4 * image.pixels());
    for (std::size_t k = 0; k < entries.size(); ++k)
      set_pixel(image, k, indices(codebook, entries[k], 255));
    if (auto ok = add_file("shN_centroids.webp", image); !ok) return ok;
    return add_image("shN_labels.webp", [&](std::uint32_t i) {
      const std::uint32_t label = palette.labels[i];
      return Pixel{static_cast<std::uint8_t>(label), static_cast<std::uint8_t>(label >> 8), 0, 255};
    });
  }

  const SplatCloud& cloud_;
  const std::string& name_;
  const WriteOptions& options_;
  std::vector<std::uint32_t> order_;
  std::vector<float> areas_;
  json meta_;
  std::vector<std::pair<std::string, Bytes>> files_;
};

}  // namespace

Expected<Bytes> encode_sog(const SplatCloud& cloud, const std::string& name,
                           const WriteOptions& options) {
  SplatCloud storage;
  const auto finite = writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  try {
    return SogEncoder(**finite, name, options).encode();
  } catch (const std::exception&) {  // bad_alloc, or length_error beyond what a vector can count
    return fail(name, "memory", "out of memory writing the scene");
  }
}

}  // namespace fluxgs
