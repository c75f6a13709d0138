// Splats parted by importance, for files of which the first bytes already show the scene.
#pragma once

#include <cstdint>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

/// The indices of some splats, ascending.
using SplatChunk = std::vector<std::uint32_t>;

/// All splats.
SplatChunk one_chunk(const SplatCloud& cloud);

/// All splats of a finite cloud, in four chunks: first the 4% (2.5% of a cloud of degree 3) that
/// add most (contribution.h), then three and six times as many, then all others; ties go by index.
/// Chunks of few splats may be empty. As large splats are stored more exactly, the first takes 5 to
/// 10% of a compact file, those before the last about a half.
std::vector<SplatChunk> importance_chunks(const SplatCloud& cloud);

}  // namespace fluxgs::io
