// LPIPS, how different two images look to people (Zhang et al., "The Unreasonable Effectiveness of
// Deep Features as a Perceptual Metric", CVPR 2018; version 0.1), by onnxruntime and the networks
// that tools/deps/lpips installs.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/networks/image_network.h"
#include "trainer/core/planar_image.h"
#include "trainer/core/progress.h"
#include "trainer/data/dataset.h"
#include "trainer/train/evaluate.h"

namespace fluxgs::cli {

/// Range that the values 0…1 of an image are mapped to for the network.
enum class LpipsRange {
  zero_to_one,  ///< as they are: what papers on splatting print, since 3DGS's metrics.py does so
  minus_one_to_one,  ///< what LPIPS is defined on
};

/// LPIPS of two images, 0 where they are the same.
struct LpipsError {
  double zero_to_one = 0, minus_one_to_one = 0;
};

class Lpips {
 public:
  /// `network`: "vgg" or "alex". Fails where onnxruntime or the network's file is missing, or where
  /// that is not the file that tools/deps/lpips makes. FLUXGS_LPIPS names its folder where it is
  /// not build/packages/lpips. `threads`: 1 or more.
  static Expected<Lpips> load(std::string_view network, int threads);

  /// The five layers' parts of LPIPS, which is their sum. Both images have 3 planes, 0…1, and one
  /// size of 32 pixels or more.
  Expected<std::array<double, 5>> layers(const PlanarImage& a, const PlanarImage& b,
                                         LpipsRange range) const;

  /// Fails where an image of that name and size is smaller than the networks' windows, or where the
  /// system has less memory than it needs: the layers' averages are of the whole image, so that it
  /// cannot be measured in parts.
  Expected<void> check_size(const std::string& image, int width, int height) const;

  const std::string& network() const { return network_; }

 private:
  Lpips(std::string network, networks::ImageNetwork features)
      : network_(std::move(network)), features_(std::move(features)) {}

  std::string network_;
  networks::ImageNetwork features_;
};

/// LPIPS of each view's image, in 8 bits a channel: the mean over the pixels that no mask ignores.
Expected<std::vector<LpipsError>> lpips_errors(const std::vector<View>& views,
                                               const ViewRenderer& render, const Lpips& lpips,
                                               const ProgressReport& progress = {});

/// The mean of both ranges, over one view or more.
LpipsError mean_of(const std::vector<LpipsError>& errors);

}  // namespace fluxgs::cli
