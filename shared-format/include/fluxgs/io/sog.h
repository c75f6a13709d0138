// SOG, "Spatially Ordered Gaussians", of PlayCanvas: splats as lossless WebP images and a meta.json
// (developer.playcanvas.com: "The SOG Format" version 2, "The Streamed SOG Format" version 1). Read
// only. Three forms: bundled (one .sog, a ZIP archive), unbundled (a folder with meta.json) and
// streamed (a folder with lod-meta.json and many unbundled scenes).
//
// Version 1 of meta.json is read, too. Attributes are those of an INRIA .ply, in its frame,
// quantized: positions in 16 bits of sign(x)·ln(|x| + 1), scales and colours by codebooks of 256,
// opacities in 8 bits (0 and 1 become finite logits, as read_glb() says), rotations in 26 bits,
// SH coefficients by a palette.
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

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"

namespace fluxgs {

/// True if the bytes begin like a .sog: a ZIP archive whose first entry is meta.json or a .webp.
bool is_sog(std::span<const std::byte> bytes);

/// Number of splats that a bundled scene announces, and their degree (3 where only its images
/// tell).
Expected<std::pair<std::size_t, int>> announced_by_sog(std::span<const std::byte> bytes,
                                                       const std::string& name);

/// Read a bundled scene. `name` appears in errors. One that announces more splats than its bytes
/// can hold is refused.
Expected<SceneFile> read_sog(std::span<const std::byte> bytes, const std::string& name);

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
