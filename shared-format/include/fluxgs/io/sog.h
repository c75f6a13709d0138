// SOG, "Spatially Ordered Gaussians", of PlayCanvas: splats as lossless WebP images and a meta.json
// (developer.playcanvas.com: "The SOG Format" version 2, "The Streamed SOG Format" version 1).
// Three forms: bundled (one .sog, a ZIP archive), unbundled (a folder with meta.json) and
// streamed (a folder with lod-meta.json and many unbundled scenes).
//
// Version 1 of meta.json is read, too. Attributes are those of an INRIA .ply, in its frame,
// quantized: positions in 16 bits of sign(x)·ln(|x| + 1), scales and colours by codebooks of 256,
// opacities in 8 bits (0 and 1 become finite logits, as read_glb() says), rotations in 26 bits,
// SH coefficients by a palette. "antialias" of meta.json (or "model": "antialiased", as
// splat-transform writes) is the compensation of SplatCloud::filter, "dilation" (ours) the rest.
//
// Files from strangers: image names must be plain and lie in the scene's folder (symbolic links
// that lead out are refused, and no file is read twice); nothing is fetched. Before memory is
// taken, every size is checked: see src/io/zip_archive.h, webp_image.h and sog_decode.h for the
// bounds.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"
#include "fluxgs/io/write_options.h"

namespace fluxgs {

/// True if the bytes look like a .sog: a ZIP archive that has meta.json or a .webp among its first
/// entries or at the end of its directory.
bool is_sog(std::span<const std::byte> bytes);

/// Number of splats that a bundled scene announces, and their degree (3 where only its images
/// tell).
Expected<std::pair<std::size_t, int>> announced_by_sog(std::span<const std::byte> bytes,
                                                       const std::string& name);

/// Read a bundled scene, which may lie in a folder of the archive; what macOS adds to archives is
/// passed over, several scenes are an error. `name` appears in errors. One that announces more
/// splats than its bytes can hold is refused.
Expected<SceneFile> read_sog(std::span<const std::byte> bytes, const std::string& name);
/// The same, but the splats go to the sink, not into the result.
Expected<SceneFile> read_sog(std::span<const std::byte> bytes, const std::string& name,
                             SplatSink& sink);

/// Write a bundled scene of version 2, in an order that keeps neighbours together. Scales, colours
/// and SH coefficients have codebooks of 256 values of (nearly) least mean squared error, SH a
/// palette of as many entries as half of the splats to all, 65,536 at most: its error is the
/// largest of this format. The time is bounded: it grows as splats · SH coefficients · log entries.
/// Splats with a NaN or infinity are left out; a scene that read_sog() would refuse, because all of
/// its splats lie in few places, is an error. The same cloud always gives the same bytes.
Expected<std::vector<std::byte>> encode_sog(const SplatCloud& cloud, const std::string& name,
                                            const WriteOptions& options = {});

/// True if the bytes look like the meta.json of an unbundled scene.
bool is_sog_meta(std::span<const std::byte> bytes);

/// Read an unbundled scene, given the content of its meta.json and where that lies. `bytes` of the
/// result counts all files.
Expected<SceneFile> read_sog_folder(std::span<const std::byte> bytes,
                                    const std::filesystem::path& path);

/// True if the bytes look like a lod-meta.json.
bool is_sog_lod(std::span<const std::byte> bytes);

/// Read level 0, the finest, of a streamed scene as one cloud, in the order of its files, given the
/// content of lod-meta.json and where that lies. Its other levels and its environment (a background
/// of far splats) are left out. The degree is the highest among the files.
Expected<SceneFile> read_sog_lod(std::span<const std::byte> bytes,
                                 const std::filesystem::path& path);

}  // namespace fluxgs
