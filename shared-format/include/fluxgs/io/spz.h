// SPZ, Niantic's compressed splats (https://github.com/nianticlabs/spz, README "File Format").
//
// Quantization, the same in all versions: position 24-bit fixed point (version 1: half floats),
// log-scale in steps of 1/16 from -10 to 5.9375, opacity 8 bits, degree-0 colour in steps of
// 1/38.25 from -3.33 to 3.33, higher bands 8 bits from -1 to 1 in steps of 1/128 or coarser.
// Rotation: versions 1 and 2 store x, y, z in 8 bits each, later ones the three smallest components
// in 10 bits each.
//
// Axes: a file does not say which it has. The specification says right-up-back ("RUB"), and so do
// Scaniverse's files and those of splat-transform before version 3; but Niantic's library converts
// only if its caller names the axes, its own ply_to_spz does not, nor do splat-transform from
// version 3 on and SuperSplat: their files have the axes of the .ply they come from,
// right-down-front
// ("RDF"), which are those of a SplatCloud. The second kind is what is read and written unless the
// caller says otherwise, so that .ply and .spz stay the same scene; the first kind then comes out
// turned by half a turn about x. Where the record SPZ_ADOBE_coordinate_system names the axes, it is
// followed; what we write has it.
//
// The flag "antialiased" is the compensation of SplatCloud::filter. SPZ has no place for the
// dilation: 0.3 px², as gsplat, PlayCanvas and others have it.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"
#include "fluxgs/io/write_options.h"

namespace fluxgs {

/// True if the bytes begin like SPZ: "NGSP" (version 4), or gzip whose content begins with it.
bool is_spz(std::span<const std::byte> bytes);

/// The axes of the values in a file.
enum class SpzAxes {
  right_down_front,  ///< those of a SplatCloud, nothing is converted
  right_up_back,     ///< those of the specification
};

/// Read versions 1 to 3 (gzip around everything) and 4 (zstd per attribute). Degree 4 is left out.
/// Opacity 0 and 1 become the finite logits that read_glb gives them. Unknown extension records are
/// skipped, as the specification asks; unknown flags, damaged records and bytes behind the end are
/// skipped with a warning.
///
/// Bombs: splats beyond the first 2^20 must take at least 1/32 of their unpacked size (19 to 65
/// bytes) in the file; real scenes take a third or more. This is checked against the header before
/// anything is allocated, and decompression ends with an error at the first byte beyond what the
/// header promises. Held at once: the file, the unpacked bytes and the cloud.
/// `axes` counts where the file does not name its own.
Expected<SceneFile> read_spz(std::span<const std::byte> bytes, const std::string& name,
                             SpzAxes axes);
/// The same, but the splats go to the sink, not into the result.
Expected<SceneFile> read_spz(std::span<const std::byte> bytes, const std::string& name,
                             SplatSink& sink, SpzAxes axes = SpzAxes::right_down_front);
/// The same with the axes that most writers use.
Expected<SceneFile> read_spz(std::span<const std::byte> bytes, const std::string& name);

/// Precision of writing; the defaults are those of other writers.
struct SpzOptions {
  int version = 3;           ///< 3 (gzip, read everywhere) or 4 (zstd, smaller)
  int fractional_bits = 12;  ///< of positions, 0 to 23: steps of 2^-12; at most, see encode_spz()
  int sh1_bits = 5;          ///< of coefficients of degree 1, 1 to 8: steps of 2^(1 - bits)
  int sh_rest_bits = 4;      ///< the same for degrees 2 and 3
  SpzAxes axes = SpzAxes::right_down_front;           ///< of the file
  bool name_axes = true;                              ///< in a record, see above
  std::function<void(const std::string&)> warn = {};  ///< see WriteOptions
};

/// Write a scene. Values beyond the ranges above are limited to them, except positions: what is
/// further than 2^(23 - bits) from the origin is moved towards the middle of the scene and made as
/// much smaller, with a warning, if that is at most one splat of 100; otherwise the bits are fewer.
/// So few far splats do not coarsen the rest. A scene of which more lies beyond 2^23 is an error.
/// Rotations come out as unit quaternions. The order stays. Splats with a NaN or infinity are left
/// out. The same cloud always gives the same bytes.
Expected<std::vector<std::byte>> encode_spz(const SplatCloud& cloud, const std::string& name,
                                            const SpzOptions& options);
/// The same with the default options.
Expected<std::vector<std::byte>> encode_spz(const SplatCloud& cloud, const std::string& name);
/// The same with the options of any writer.
Expected<std::vector<std::byte>> write_spz(const SplatCloud& cloud, const std::string& name,
                                           const WriteOptions& options);

}  // namespace fluxgs
