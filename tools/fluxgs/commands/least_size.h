// The size below which no compact file of a scene can go.
#pragma once

#include <cstddef>
#include <optional>

#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::cli {

/// Bytes of a compact file.
struct LeastSize {
  std::size_t start = 0;      ///< of its start view, at most
  std::size_t one_splat = 0;  ///< of a file of one splat, which is all zeros, with the start view
};

/// Stores one splat with the degree and the filter of `cloud`. Fails as encode_compact_glb() and
/// with_initial_view() do.
Expected<LeastSize> least_size(const SplatCloud& cloud, const std::optional<InitialView>& start,
                               const CompactOptions& options);

}  // namespace fluxgs::cli
