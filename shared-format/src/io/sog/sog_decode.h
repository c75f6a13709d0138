// The splats of one SOG scene: the images that its meta.json names, decoded.
#pragma once

#include <cstddef>
#include <string>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"
#include "io/sog/named_files.h"
#include "io/sog/sog_meta.h"

namespace fluxgs::io {

/// The most splats that so many bytes of images of positions, or of a whole archive, may hold.
constexpr std::size_t max_sog_splats(std::size_t bytes) { return 65536 + 16 * bytes; }

/// Decode all images. `folder` ("" or with a slash at its end) goes before their names. Refused by
/// name:
/// - more splats than max_sog_splats() of the two images of positions, so that the memory of the
///   cloud is bounded by the size of the files;
/// - images with fewer pixels than splats, or more than 2^20 + 4 times as many;
/// - bytes beyond a codebook, modes of a quaternion other than 252 to 255, labels beyond the
///   palette.
/// The images are in memory all at once, besides the palette and what the sink makes of the splats;
/// the result gets degree, filter and what was dropped.
Expected<void> decode_sog(const SogMeta& meta, const NamedFiles& files, const std::string& folder,
                          const std::string& name, SplatSink& sink, SceneFile& scene);

}  // namespace fluxgs::io
