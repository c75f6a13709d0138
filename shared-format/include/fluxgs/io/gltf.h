// glTF 2.0, binary or JSON, with the ratified extension KHR_gaussian_splatting (kernel "ellipse").
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"

namespace fluxgs {

/// True if the bytes begin like a .glb.
bool is_glb(std::span<const std::byte> bytes);

/// The chunks of a .glb, of which only the JSON is read: those whose `end` has come can be shown.
/// None where all splats come at once, and of other files.
Expected<std::vector<SceneChunk>> find_chunks(const ByteSource& file, const std::string& name);

/// The size that a .glb, of which these are the first bytes, says it has; nothing of other bytes.
std::optional<std::uint64_t> size_of_glb(std::span<const std::byte> begin);

/// Turns a cloud from its frame into glTF's, or back: half a turn about z, x → −x, y → −y. Exact
/// but for the signs of quaternions, which mean nothing.
void turn_gltf_frame(SplatCloud& cloud);

/// Read every splat primitive of the default scene (without one: of the first, or of all root
/// nodes) into one cloud, its nodes' transforms applied (transform.h), turned from glTF's frame (y
/// up) into that of a SplatCloud (y down) by half a turn about z. The degree is the highest among
/// the primitives; missing bands are zero. Scales that are mostly negative are logarithms, as a
/// draft of the extension had them.
///
/// Splats compressed by SPZ are read too, by all drafts of that extension
/// (KHR_gaussian_splatting_compression_spz_2 the last), with the bounds of spz.h; the drafts and
/// those who write by them disagree about the axes, and the bounds of POSITION tell which it was.
///
/// Colours in linear light ("lin_rec709_display") become sRGB, splat by splat: the harmonics
/// nearest to what each shows. Splats that blend look a little different, and a warning says so. A
/// warning also names nodes that stretch splats with view-dependent colours (transform.h).
///
/// Memory only: nothing is fetched. Buffers may be data: URIs; other URIs of buffers are refused by
/// name, those of images do not matter. Refused by name too: required extensions that we do not
/// know, splats compressed otherwise, kernels other than "ellipse", other colour spaces, transforms
/// that flatten. All counts are checked against the size of `bytes` before anything is allocated,
/// and instances of a mesh may not make more than one splat per 8 bytes of the file (compressed: 2
/// per byte, or 2^20).
///
/// glTF stores opacity and scale themselves, a cloud their logit and logarithm. So that the ends of
/// the range stay finite, opacity ≤ 0 becomes logit ≈ −87.3 (2⁻¹²⁶), opacity ≥ 1 becomes ≈ 17.3
/// (1 − 2⁻²⁵, half-way to the float below one) and scale 0 becomes logarithm ≈ −87.3. Negative
/// scales are invalid: such splats count as dropped.
Expected<SceneFile> read_glb(std::span<const std::byte> bytes, const std::string& name);
/// The same, but the splats go to the sink, not into the result, primitive by primitive. Of a file
/// with compact splats each primitive is read when those before it have been taken, so that a file
/// that comes slowly, or ends too early, gives what has come (SplatSink::chunk_came()).
Expected<SceneFile> read_glb(const ByteSource& file, const std::string& name, SplatSink& sink);

/// True if the bytes look like the JSON form of glTF, a .gltf.
bool is_gltf(std::span<const std::byte> bytes);

/// Read the JSON form, as read_glb() does.
Expected<SceneFile> read_gltf(std::span<const std::byte> bytes, const std::string& name);
/// The same, but the splats go to the sink, not into the result, primitive by primitive.
Expected<SceneFile> read_gltf(std::span<const std::byte> bytes, const std::string& name,
                              SplatSink& sink);

/// Read a .glb or .gltf whose buffers may be files, given its content and where it lies. Names of
/// files must be plain and lie in its folder or below (symbolic links that lead out are refused);
/// a file may be larger than its buffer by 4,096 bytes. `bytes` of the result counts all files.
Expected<SceneFile> read_gltf_folder(std::span<const std::byte> bytes,
                                     const std::filesystem::path& path);

/// Precision of encode_glb().
struct GlbOptions {
  /// 32: floats. 16 or 8: rotations as signed, scales and opacities as unsigned normalized integers
  /// of so many bits, as KHR_gaussian_splatting allows; positions and SH coefficients are floats in
  /// any case, which it demands (of positions unless another extension is required).
  int attribute_bits = 32;
};

/// Order of a finite cloud's splats in the file: order[k] is the index in the cloud of splat k of
/// the file. That of the cloud for 32 bits.
std::vector<std::uint32_t> glb_order(const SplatCloud& cloud, const GlbOptions& options);

/// Write a scene with these options. Integers reach from 0 to the scale of their node, so that each
/// size of splats has a node of its own, evenly scaled by a power of two, and positions lose
/// nothing: with 16 bits the sizes of a node are within a factor of 256, with 8 bits of 4 (few
/// splats go with the next larger ones). Scales above 0 stay so.
Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const GlbOptions& options,
                                            const std::string& name);

/// Write one node with one POINTS primitive: float attributes, unit quaternions, and COLOR_0
/// (linear, 8 bits) for viewers that do not know the extension. A screen filter other than the
/// classic one is in `extras` of the extension's object (schema/README.md). Scales and opacities
/// beyond the range of float are limited to it. Splats with a NaN or infinity are left out. A scene
/// without splats is written without a mesh (glTF has no empty accessors) and so loses its degree.
/// An error if the file would exceed the 4 GiB that a .glb can hold.
Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const std::string& name);

}  // namespace fluxgs
