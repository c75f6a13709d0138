// A whole scene in few bits: positions through Draco, everything else through channels.h.
#pragma once

#include <cstddef>

#include "codec/bytes.h"
#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::codec {

/// How coarsely each attribute is rounded: smaller steps, more bytes, less error. All > 0.
struct CompactSteps {
  double position = 1e-3;  ///< scene units
  float log_scale = 0.2f;  ///< of the natural logarithm
  float rotation = 0.06f;  ///< of the quaternion's x, y, z; for usual splats, see importance.h
  float opacity = 0.06f;   ///< of opacity_scale(), 0…1
  float sh_dc = 0.08f;     ///< of the coefficient, 0.28 of which is colour; for usual splats
  float sh_rest = 0.1f;
};

/// Opacity on a scale of 0…1 that is finer towards both ends, where its effect is largest:
/// asin(√opacity)·2/π.
float opacity_scale(float logit);

/// Encodes the finite cloud in the Morton order of its positions (codec/morton.h): the order of the
/// splats is lost, their number is not. Rotations lose what a covariance does not have: their
/// length, their sign and half turns about the splat's own axes. An error names the attribute.
Expected<Bytes> encode_compact(const SplatCloud& cloud, const CompactSteps& steps);

/// Decodes `count` splats of a degree that the caller has checked against its limits. Holds at most
/// the bytes, the cloud, and 64 bytes a splat. Errors (without a file's name) name the attribute.
Expected<SplatCloud> decode_compact(std::span<const std::byte> bytes, std::size_t count,
                                    int sh_degree);

/// Bytes that each attribute takes in an encoded scene, in the order of kAttributeNames.
inline constexpr const char* kAttributeNames[] = {"position", "scale", "opacity",
                                                  "rotation", "sh_dc", "sh_rest"};
Expected<std::vector<std::size_t>> attribute_bytes(std::span<const std::byte> bytes);

}  // namespace fluxgs::codec
