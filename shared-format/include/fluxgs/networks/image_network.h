// A convolutional network from an image to feature maps, run by onnxruntime. For networks of our
// own making: the file is handed to onnxruntime as it is.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::networks {

/// One output of a network: float32, channels × height × width.
struct FeatureMap {
  int channels = 0;                   ///< planes
  int height = 0;                     ///< rows of a plane
  int width = 0;                      ///< columns of a plane
  std::span<const float> values;      ///< of `owner`
  std::shared_ptr<const void> owner;  ///< keeps the values
};

/// Not thread-safe, nor are copies, which share one session.
class ImageNetwork {
 public:
  /// `model`: bytes of an ONNX file with one input "image", float32 of 1 × 3 × height × width.
  /// `outputs`: names of those that run() returns; `threads`: that one run takes, 1 or more. Loads
  /// onnxruntime (onnx_runtime.h); an error says where it was looked for.
  static Expected<ImageNetwork> load(std::span<const std::byte> model,
                                     std::vector<std::string> outputs, int threads);

  /// The outputs for an image: 3 planes of height × width, rows without gaps. Fails where memory
  /// runs out, and on images too small for the network's windows.
  Expected<std::vector<FeatureMap>> run(std::span<const float> planes, int height, int width) const;

 private:
  struct Session;
  explicit ImageNetwork(std::shared_ptr<const Session> session) : session_(std::move(session)) {}
  std::shared_ptr<const Session> session_;
};

}  // namespace fluxgs::networks
