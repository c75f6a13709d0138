// Binary glTF 2.0 with the ratified extension KHR_gaussian_splatting (kernel "ellipse").
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"

namespace fluxgs {

/// True if the bytes begin like a .glb.
bool is_glb(std::span<const std::byte> bytes);

/// Turns a cloud from its frame into glTF's, or back: half a turn about z, x → −x, y → −y. Exact
/// but for the signs of quaternions, which mean nothing.
void turn_gltf_frame(SplatCloud& cloud);

/// Read every splat primitive of the default scene (without one: of the first, or of all root
/// nodes) into one cloud, its nodes' transforms applied, turned from glTF's frame (y up) into that
/// of a SplatCloud (y down) by half a turn about z. The degree is the highest among the primitives;
/// missing bands are zero.
///
/// Splats compressed by KHR_gaussian_splatting_compression_spz_2 are read too, with the bounds of
/// spz.h; the draft of that extension and those who write it disagree about the axes, and the
/// bounds of POSITION tell which it was.
///
/// Memory only: nothing is fetched, every URI is refused by name. Refused by name too: required
/// extensions we do not know, splats compressed otherwise, sparse accessors, kernels other than
/// "ellipse", colour spaces other than "srgb_rec709_display", transforms with shear, mirroring or
/// non-uniform scale. All counts are checked against the size of `bytes` before anything is
/// allocated, and instances of a mesh may not make more than one splat per 8 bytes of the file
/// (compressed: 2 per byte, or 2^20).
///
/// glTF stores opacity and scale themselves, a cloud their logit and logarithm. So that the ends of
/// the range stay finite, opacity ≤ 0 becomes logit ≈ −87.3 (2⁻¹²⁶), opacity ≥ 1 becomes ≈ 17.3
/// (1 − 2⁻²⁵, half-way to the float below one) and scale 0 becomes logarithm ≈ −87.3. Negative
/// scales are invalid: such splats count as dropped.
Expected<SceneFile> read_glb(std::span<const std::byte> bytes, const std::string& name);

/// Write one node with one POINTS primitive: float attributes, unit quaternions, and COLOR_0
/// (linear, 8 bits) for viewers that do not know the extension. Scales and opacities beyond the
/// range of float are limited to it. Splats with a NaN or infinity are left out. A scene without
/// splats is written without a mesh (glTF has no empty accessors) and so loses its degree. An error
/// if the file would exceed the 4 GiB that a .glb can hold.
Expected<std::vector<std::byte>> encode_glb(const SplatCloud& cloud, const std::string& name);

}  // namespace fluxgs
