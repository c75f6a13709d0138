// A whole scene in few bits: positions as an octree, everything else through channels.h.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include "codec/bytes.h"
#include "codec/positions.h"
#include "codec/step_means.h"
#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::codec {

/// The most splats that this many bytes may hold: real scenes take five bytes or more for each, so
/// that a few bytes cannot ask for gigabytes of memory. What the encoder makes of simpler ones is
/// padded with zeros.
constexpr std::size_t max_splats(std::size_t bytes) { return 4096 + bytes; }

inline constexpr std::size_t kEnergyChannels = 12;

/// The rotation that is stored for another, not yet quantized.
glm::quat canonical_rotation(const glm::quat& rotation);

/// Opacity on a scale of 0…1 that is finer towards both ends, where its effect is largest:
/// asin(√opacity)·2/π.
float opacity_scale(float logit);

/// Encodes the finite cloud in the position_order() of its positions: the order of the splats is
/// lost, their number is not. Rotations lose what a covariance does not have: their
/// length, their sign and half turns about the splat's own axes. Costs are those of the cloud, in
/// its frame. An error names the attribute.
///
/// With `energy` (kEnergyChannels a splat) its steps and the weights of errors are used, its
/// networks are not, and colours are not stored. `rates` are for the part of a scene
/// (step_means.h).
Expected<Bytes> encode_compact(const SplatCloud& cloud, const CompactOptions& options,
                               std::span<const float> energy = {}, const RateFactors& rates = {});

/// Decodes `count` splats, max_splats(bytes.size()) at most. Holds at most the bytes, the cloud,
/// and 64 bytes a splat (with energy 128; of degree 2 and 3: 24, and 12 for each coefficient).
/// Errors (without a file's name) name the attribute. If `energy` is given, the stream has it
/// instead of colours, which stay zero. `cells` is as the file's version says.
Expected<SplatCloud> decode_compact(std::span<const std::byte> bytes, std::size_t count,
                                    int sh_degree, std::vector<float>* energy = nullptr,
                                    CellCoding cells = CellCoding::octree);

/// Bytes that each attribute takes in an encoded scene, by name.
Expected<std::vector<std::pair<std::string, std::size_t>>> attribute_bytes(
    std::span<const std::byte> bytes, int sh_degree, bool has_energy = false);

}  // namespace fluxgs::codec
