// The .splat format of antimatter15's viewer: 32 bytes a splat, without header or magic.
//
//   offset  bytes
//        0  12     position, 3 × float
//       12  12     scale (standard deviations, linear), 3 × float
//       24   4     red, green, blue, opacity: 0…255 for 0…1
//       28   4     quaternion w, x, y, z: each 128·q + 128
//
// Little-endian; the frame is that of a SplatCloud. View dependence is not stored.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"

namespace fluxgs {

/// True if the bytes look like .splat records. Without a magic this is a guess, to be made after
/// every other format has declined: of up to 256 records spread over the file at least half are
/// plausible (positions and scales within ±10⁹, scales not negative, quaternions of unit length but
/// for their rounding). One record of random bytes passes with probability 0.0005; text, zeros and
/// bytes of 255 never do. A size that is no multiple of 32 needs four whole records, nine of ten of
/// them plausible.
bool is_splat(std::span<const std::byte> bytes);

/// Read a scene of degree 0 in the order of the file. Bytes behind the last whole record, as a
/// download that stopped leaves them, are ignored with a warning; a file without one is an error.
/// Opacities of 0 and 255 stay finite: logits ≈ −87.3 and 17.3. A scale of 0
/// becomes logarithm ≈ −87.3; splats with a negative scale count as dropped; a zero quaternion
/// becomes the identity.
Expected<SceneFile> read_splat(std::span<const std::byte> bytes, const std::string& name);
/// The same of a file that need not be in memory. The splats go to the sink, not into the result.
Expected<SceneFile> read_splat(const ByteSource& source, const std::string& name, SplatSink& sink);

/// Write degree 0 of a scene (higher degrees are left out) in the order of the cloud; other writers
/// sort by size, for viewers that draw while loading. Rounding to the nearest level errs by at most
/// 1/510 in opacity and colour and 1/256 in each component of the unit quaternion (1/128 towards
/// component 1, which has no level of its own); colours are limited to 0…1. A file that was read is
/// written again with the same bytes but for the last bits of its scales. Splats with a NaN or
/// infinity are left out; a scene without splats is an error, for it would be an empty file, and so
/// is one that is_splat() would not know again.
Expected<std::vector<std::byte>> encode_splat(const SplatCloud& cloud, const std::string& name);

}  // namespace fluxgs
