// The splats of one SOG scene: the images that its meta.json names, decoded.
#pragma once

#include <cstddef>
#include <string>

#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"
#include "io/sog/named_files.h"
#include "io/sog/sog_meta.h"

namespace fluxgs::io {

/// The most splats that so many bytes of images of positions, or of a whole archive, may hold.
constexpr std::size_t max_sog_splats(std::size_t bytes) { return 65536 + 16 * bytes; }

/// Decode all images. `folder` ("" or with a slash at its end) goes before their names. Splats may
/// come out with infinite attributes. Refused by name:
/// - more splats than max_sog_splats() of the two images of positions, so that the memory of the
///   cloud is bounded by the size of the files;
/// - images with fewer pixels than splats, or more than 2^20 + 4 times as many;
/// - bytes beyond a codebook, modes of a quaternion other than 252 to 255, labels beyond the
///   palette.
/// One image is in memory at a time (of positions two), besides the cloud and the palette.
Expected<SplatCloud> decode_sog(const SogMeta& meta, const NamedFiles& files,
                                const std::string& folder, const std::string& name);

}  // namespace fluxgs::io
