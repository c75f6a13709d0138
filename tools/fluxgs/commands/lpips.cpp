#include "tools/fluxgs/commands/lpips.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>

#include <fmt/format.h>
#include <zlib.h>

#include "fluxgs/io/file.h"
#include "fluxgs/sanitize.h"
#include "trainer/core/free_memory.h"
#include "trainer/data/photo_memory.h"
#include "trainer/loss/photometric.h"

namespace fluxgs::cli {
namespace {

constexpr int kSmallest = 32;  // px: below, a window of AlexNet is larger than what it looks at
constexpr double kMebibyte = 1 << 20;

struct Network {
  std::string_view name;
  std::size_t bytes;    // of the file that tools/deps/lpips makes
  std::uint32_t crc32;  // of these bytes
  double fixed_memory;  // bytes, whatever the image; measured
  double pixel_memory;  // bytes a pixel
};
constexpr std::array kNetworks = {Network{"vgg", 58'868'511, 0xe46bcbb0, 230e6, 1500},
                                  Network{"alex", 9'885'750, 0xcab3db8c, 45e6, 170}};

const Network* find_network(std::string_view name) {
  const auto* found = std::ranges::find(kNetworks, name, &Network::name);
  return found == kNetworks.end() ? nullptr : found;
}

std::string package_folder() {
  const char* named = std::getenv("FLUXGS_LPIPS");
  return named != nullptr && *named != 0 ? named : FLUXGS_LPIPS_FOLDER;
}

/// The planes without the gaps between rows, in the range that the network takes.
std::vector<float> input_of(const PlanarImage& image, LpipsRange range) {
  std::vector<float> planes;
  planes.reserve(3 * static_cast<std::size_t>(image.width()) *
                 static_cast<std::size_t>(image.height()));
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        const float value = image.row(c, y)[x];
        planes.push_back(range == LpipsRange::zero_to_one ? value : 2 * value - 1);
      }
  return planes;
}

/// The mean over the pixels of the squared distance of two maps.
double distance(const networks::FeatureMap& a, const networks::FeatureMap& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double d = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
    sum += d * d;
  }
  return sum / (static_cast<double>(a.width) * a.height);
}

void round_to_bytes(PlanarImage& image) {
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < image.height(); ++y) {
      float* row = image.row(c, y);
      std::transform(row, row + image.width(), row,
                     [](float v) { return std::round(std::clamp(v, 0.0F, 1.0F) * 255) / 255; });
    }
}

double total(const std::array<double, 5>& layers) {
  return std::accumulate(layers.begin(), layers.end(), 0.0);
}

}  // namespace

Expected<Lpips> Lpips::load(std::string_view name, int threads) {
  const Network* network = find_network(name);
  if (!network) return fail("LPIPS", std::string(name), "unknown; vgg or alex was expected");
  const std::string folder = package_folder();
  const std::string advice =
      "tools/deps/lpips in a checkout makes it, FLUXGS_LPIPS names the folder where it lies";
  if (folder.empty()) return fail("LPIPS", std::string(name), "its network is missing; " + advice);
  const auto path = std::filesystem::path(folder) / fmt::format("{}.onnx", name);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return fail(path.string(), "", "is not there; " + advice);
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes->data()), bytes->size());
  if (bytes->size() != network->bytes || crc != network->crc32)
    return fail(path.string(), "", "is not the network that LPIPS is measured with; " + advice);
  auto features = networks::ImageNetwork::load(
      *bytes, {"layer0", "layer1", "layer2", "layer3", "layer4"}, threads);
  if (!features) return std::unexpected(features.error());
  return Lpips(std::string(name), std::move(*features));
}

Expected<void> Lpips::check_size(const std::string& image, int width, int height) const {
  if (std::min(width, height) < kSmallest) {
    return fail(one_line(image), "",
                fmt::format("{}×{} pixels, but --lpips needs {} a side; a smaller --downscale, or "
                            "eval without --lpips",
                            width, height, kSmallest));
  }
  const double pixels = static_cast<double>(width) * height;
  const auto needs = [&](const Network& n) { return n.fixed_memory + n.pixel_memory * pixels; };
  const double need = needs(*find_network(network_));
  const auto free = available_memory();
  if (!free || need <= static_cast<double>(*free)) return {};
  std::string advice = "--downscale makes them smaller";
  if (network_ == "vgg")
    advice +=
        fmt::format(", --lpips alex needs {:.0f} MiB", needs(*find_network("alex")) / kMebibyte);
  return fail(
      one_line(image), "",
      fmt::format("LPIPS of {}×{} pixels needs about {:.0f} MiB, {:.0f} are free; {}", width,
                  height, need / kMebibyte, static_cast<double>(*free) / kMebibyte, advice));
}

Expected<std::array<double, 5>> Lpips::layers(const PlanarImage& a, const PlanarImage& b,
                                              LpipsRange range) const {
  if (a.width() != b.width() || a.height() != b.height())
    return fail("LPIPS", "images", "are not of one size");
  const auto of_a = features_.run(input_of(a, range), a.height(), a.width());
  if (!of_a) return std::unexpected(of_a.error());
  const auto of_b = features_.run(input_of(b, range), b.height(), b.width());
  if (!of_b) return std::unexpected(of_b.error());
  std::array<double, 5> parts{};
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = distance((*of_a)[i], (*of_b)[i]);
  return parts;
}

Expected<std::vector<LpipsError>> lpips_errors(const std::vector<View>& views,
                                               const ViewRenderer& render, const Lpips& lpips,
                                               const ProgressReport& progress) {
  const Threads one_thread(1);
  PlanarImage photo;
  std::vector<LpipsError> errors;
  for (const View& view : views) {
    if (auto ok = lpips.check_size(view.camera.name, view.camera.width, view.camera.height); !ok)
      return std::unexpected(ok.error());
    auto image = render(view.camera);
    if (!image) return std::unexpected(image.error());
    to_planar(view.rgb, one_thread, photo);
    fill_unused(view.used, *image, photo);
    round_to_bytes(*image);
    round_to_bytes(photo);
    LpipsError& error = errors.emplace_back();
    for (const auto& [range, value] :
         {std::pair(LpipsRange::zero_to_one, &error.zero_to_one),
          std::pair(LpipsRange::minus_one_to_one, &error.minus_one_to_one)}) {
      const auto parts = lpips.layers(photo, *image, range);
      if (!parts) return std::unexpected(parts.error());
      *value = total(*parts) / used_share(view.used);  // no error where a mask ignores pixels
    }
    let_go(view);
    if (progress) progress(errors.size(), views.size());
  }
  return errors;
}

LpipsError mean_of(const std::vector<LpipsError>& errors) {
  LpipsError mean;
  for (const LpipsError& error : errors) {
    mean.zero_to_one += error.zero_to_one / static_cast<double>(errors.size());
    mean.minus_one_to_one += error.minus_one_to_one / static_cast<double>(errors.size());
  }
  return mean;
}

}  // namespace fluxgs::cli
