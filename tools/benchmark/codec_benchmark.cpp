// Why the compact codec is built as it is: scalar channels against codebooks of sub-vectors, rANS
// against other entropy coders, and how long reading takes.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>
#include <fmt/format.h>
#include <zstd.h>
#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>

#include "codec/channels.h"
#include "codec/quantization.h"
#include "codec/rans.h"
#include "codec/scales.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "trainer/core/clock.h"
#include "trainer/core/median.h"

namespace fluxgs {
namespace {

using codec::Channels;

struct Settings {
  std::string scene, out;
  std::size_t splats = 360'000;
  int sh_degree = 1;
};

/// The median of several runs, in milliseconds.
template <class Work>
double milliseconds(const Work& work, int runs = 9) {
  std::vector<double> times;
  for (int i = 0; i < runs; ++i) {
    const double start = wall_seconds();
    work();
    times.push_back(1e3 * (wall_seconds() - start));
  }
  return *median(times);
}

struct Attribute {
  const char* name;
  Channels values;
  float step;
};

void append(Channels& to, const glm::vec3& v) {
  for (int c = 0; c < 3; ++c) to.values.push_back(v[c]);
}

/// Attributes of a scene in the order of a compact file.
std::vector<Attribute> attributes_of(const SplatCloud& cloud, const QuantizationSteps& steps) {
  codec::Stepped roots = codec::roots_of(cloud.log_scales, steps.log_scale);
  std::vector<Attribute> list{{"scale", {3, std::move(roots.values)}, roots.step},
                              {"rotation", {3, {}}, steps.rotation},
                              {"sh_dc", {3, {}}, steps.sh_dc}};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::quat q = cloud.rotations[i];
    append(list[1].values, glm::vec3(q.x, q.y, q.z) * (q.w < 0 ? -1.0f : 1.0f));
    append(list[2].values, cloud.sh_dc[i]);
  }
  if (cloud.sh_degree == 0) return list;
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  list.push_back({"sh_rest", {3 * rest, {}}, steps.sh_rest});
  for (const glm::vec3& v : cloud.sh_rest) append(list[3].values, v);
  return list;
}

struct CodebookCost {
  double mse = 0, bits = 0;  ///< per value; per splat
};

/// Sub-vectors of `width` neighbouring channels, each with a codebook of `size` entries by k-means,
/// indices at their entropy, tables as 16-bit numbers.
CodebookCost codebook_cost(const Channels& input, std::size_t width, int size) {
  constexpr std::size_t kTrained = 30'000;
  const std::size_t n = input.splats();
  CodebookCost cost;
  for (std::size_t first = 0; first + width <= input.channels; first += width) {
    const auto rows = static_cast<int>(n);
    cv::Mat all(rows, static_cast<int>(width), CV_32F);
    for (int i = 0; i < rows; ++i)
      for (std::size_t c = 0; c < width; ++c)
        all.at<float>(i, static_cast<int>(c)) =
            input.values[static_cast<std::size_t>(i) * input.channels + first + c];
    cv::Mat sample;
    const std::size_t stride = std::max<std::size_t>(n / kTrained, 1);
    for (std::size_t i = 0; i < n; i += stride) sample.push_back(all.row(static_cast<int>(i)));
    cv::Mat labels, centers;
    cv::setRNGSeed(1);
    cv::kmeans(sample, std::min(size, sample.rows), labels, {cv::TermCriteria::COUNT, 8, 0}, 1,
               cv::KMEANS_PP_CENTERS, centers);
    std::vector<std::int32_t> indices(n);
    for (int i = 0; i < rows; ++i) {
      float best = std::numeric_limits<float>::max();
      for (int k = 0; k < centers.rows; ++k) {
        float distance = 0;
        for (int c = 0; c < all.cols; ++c) {
          const float d = all.at<float>(i, c) - centers.at<float>(k, c);
          distance += d * d;
        }
        if (distance < best) best = distance, indices[static_cast<std::size_t>(i)] = k;
      }
      cost.mse += double{best};
    }
    cost.bits += codec::entropy_bits(indices) + 16.0 * centers.rows * static_cast<double>(width);
  }
  cost.mse /= static_cast<double>(n * input.channels);
  cost.bits /= static_cast<double>(n);
  return cost;
}

/// Bits a splat of the codec's channels at a mean square error, rounding to the nearest.
double channel_bits(const Channels& input, double mse) {
  const auto bits = codec::channels_bits(input, static_cast<float>(std::sqrt(12 * mse)));
  return bits ? *bits / static_cast<double>(input.splats()) : std::nan("");
}

void compare_codebooks(const std::vector<Attribute>& attributes) {
  fmt::print("\nCodebooks of sub-vectors against scalar channels at the same mean square error\n");
  fmt::print("{:<10}{:>7}{:>7}{:>12}{:>12}{:>12}{:>9}\n", "attribute", "width", "size", "rms error",
             "codebook", "channels", "ratio");
  for (const Attribute& a : attributes)
    for (const std::size_t width : {1u, 2u, 3u})
      for (const int size : {64, 256, 1024}) {
        if (a.values.channels % width != 0) continue;
        const CodebookCost cost = codebook_cost(a.values, width, size);
        const double channels = channel_bits(a.values, cost.mse);
        fmt::print("{:<10}{:>7}{:>7}{:>12.4g}{:>7.2f} bits{:>7.2f} bits{:>9.2f}\n", a.name, width,
                   size, std::sqrt(cost.mse), cost.bits, channels, channels / cost.bits);
      }
}

using Numbers = std::vector<std::int32_t>;

/// Whole numbers as the codec codes them, channel by channel, but without its turn of the channels.
std::vector<Numbers> numbers_of(const Attribute& a) {
  std::vector<Numbers> all;
  for (std::size_t c = 0; c < a.values.channels; ++c) {
    std::vector<double> plane(a.values.splats());
    for (std::size_t i = 0; i < plane.size(); ++i)
      plane[i] = double{a.values.values[i * a.values.channels + c]} / double{a.step};
    all.push_back(codec::quantize_cheaply(plane, true, {}));
  }
  return all;
}

struct CoderCost {
  double bits = 0, decode_ms = 0;
};

CoderCost rans_cost(const Numbers& original) {
  Numbers numbers = original;
  codec::Bytes out;
  codec::encode_values({&original, 1}, out);
  const double ms = milliseconds([&] {
    ByteReader in(out);
    auto decoder = codec::ValueDecoder::open(in, 1);
    if (!decoder || !decoder->next(numbers)) std::abort();
  });
  return {8.0 * static_cast<double>(out.size()), ms};
}

/// A byte a number, two planes of bytes where one does not do.
CoderCost zstd_cost(const Numbers& numbers) {
  std::vector<std::uint8_t> low, high;
  for (const std::int32_t n : numbers) {
    const std::uint64_t z = codec::zigzag(n);
    low.push_back(static_cast<std::uint8_t>(z));
    high.push_back(static_cast<std::uint8_t>(z >> 8));
  }
  low.insert(low.end(), high.begin(), high.end());
  std::vector<std::uint8_t> packed(ZSTD_compressBound(low.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), low.data(), low.size(), 19));
  const double ms =
      milliseconds([&] { ZSTD_decompress(low.data(), low.size(), packed.data(), packed.size()); });
  return {8.0 * static_cast<double>(packed.size()), ms};
}

CoderCost draco_cost(const Numbers& numbers) {
  std::vector<std::uint32_t> symbols;
  for (const std::int32_t n : numbers)
    symbols.push_back(static_cast<std::uint32_t>(codec::zigzag(n)));
  draco::EncoderBuffer buffer;
  draco::EncodeSymbols(symbols.data(), static_cast<int>(symbols.size()), 1, nullptr, &buffer);
  const double ms = milliseconds([&] {
    draco::DecoderBuffer in;
    in.Init(buffer.data(), buffer.size());
    in.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
    draco::DecodeSymbols(static_cast<std::uint32_t>(symbols.size()), 1, &in, symbols.data());
  });
  return {8.0 * static_cast<double>(buffer.size()), ms};
}

void compare_coders(const std::vector<Attribute>& attributes) {
  fmt::print("\nEntropy coders, each channel by itself: bits a splat, ms to decode\n");
  fmt::print("{:<10}{:>20}{:>20}{:>20}\n", "attribute", "rANS", "Draco", "zstd 19");
  for (const Attribute& a : attributes) {
    fmt::print("{:<10}", a.name);
    const auto channels = numbers_of(a);
    for (const auto coder : {rans_cost, draco_cost, zstd_cost}) {
      CoderCost sum;
      for (const Numbers& numbers : channels) {
        const CoderCost cost = coder(numbers);
        sum.bits += cost.bits / static_cast<double>(numbers.size());
        sum.decode_ms += cost.decode_ms;
      }
      fmt::print("{:>12.3f} {:>4.1f} ms", sum.bits, sum.decode_ms);
    }
    fmt::print("\n");
  }
}

/// Copies of the scene side by side until there are `count` splats.
SplatCloud tiled(const SplatCloud& cloud, std::size_t count) {
  float reach = 0;
  for (const glm::vec3& p : cloud.positions) reach = std::max(reach, std::abs(p.x));
  std::vector<std::uint32_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = static_cast<std::uint32_t>(i % cloud.size());
  SplatCloud result = in_order(cloud, order);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t copy = i / cloud.size();
    result.positions[i].x += 2 * reach * static_cast<float>(copy);
  }
  return result;
}

Expected<void> time_reading(const Settings& s, const SplatCloud& cloud) {
  const SplatCloud many = tiled(cloud, s.splats);
  const CompactOptions options{.steps = default_quantization_steps(cloud)};
  std::vector<std::byte> file;
  const double encode =
      milliseconds([&] { file = *encode_compact_glb(many, options, "scene"); }, 3);
  const double decode = milliseconds([&] {
    if (!read_scene(file, "scene")) std::abort();
  });
  fmt::print(
      "\n{} splats of degree {} (copies of the scene): {} bytes, {:.1f} bits a splat\n"
      "encode {:.0f} ms, read {:.0f} ms, one core\n",
      many.size(), many.sh_degree, file.size(),
      8.0 * static_cast<double>(file.size()) / static_cast<double>(many.size()), encode, decode);
  return s.out.empty() ? Expected<void>() : write_file_atomic(s.out, file);
}

Expected<void> run(const Settings& s) {
  auto scene = read_scene(std::filesystem::path(s.scene));
  if (!scene) return std::unexpected(scene.error());
  limit_sh_degree(scene->cloud, s.sh_degree);
  if (scene->cloud.size() == 0) return fail(s.scene, "", "has no splats");
  const SplatCloud cloud = in_order(scene->cloud, compact_order(scene->cloud));
  fmt::print("{}: {} splats of degree {}\n", s.scene, cloud.size(), cloud.sh_degree);
  const auto attributes = attributes_of(cloud, default_quantization_steps(cloud));
  if (auto ok = time_reading(s, cloud); !ok) return ok;
  compare_coders(attributes);
  compare_codebooks(attributes);
  return {};
}

}  // namespace
}  // namespace fluxgs

int main(int argc, char** argv) {
  CLI::App app("Measures the parts of the compact codec on a scene.");
  fluxgs::Settings settings;
  app.add_option("scene", settings.scene, "the scene file")->required();
  app.add_option("--splats", settings.splats, "copies of the scene for the timing")
      ->check(CLI::Range(1, 20'000'000))
      ->capture_default_str();
  app.add_option("--sh-degree", settings.sh_degree, "highest degree to keep")
      ->check(CLI::Range(0, 3))
      ->capture_default_str();
  app.add_option("--out", settings.out, "write the file of the timing here");
  app.footer("Example: codec_benchmark garden.glb --out large.glb");
  CLI11_PARSE(app, argc, argv);
  const auto done = fluxgs::run(settings);
  if (!done) fmt::print(stderr, "codec_benchmark: error: {}\n", done.error().message());
  return done ? 0 : 1;
}
