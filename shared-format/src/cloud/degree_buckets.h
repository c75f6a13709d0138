// Splats sorted by the SH degree that they need, for files that store each degree by
// itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

/// Splats of one degree.
struct DegreeBucket {
  int sh_degree = 0;
  std::vector<std::uint32_t> splats;  ///< their indices in the cloud, ascending
};

/// Fewer splats than this go into the bucket above: what describes a bucket in a file (its JSON,
/// its tables) takes more bytes than the bands that they do without.
inline constexpr std::size_t kMinBucket = 512;

/// These splats of the cloud, ascending, in buckets of ascending degrees, none of them empty.
std::vector<DegreeBucket> degree_buckets(const SplatCloud& cloud,
                                         std::span<const std::uint32_t> splats);

/// The splats of a bucket as a cloud of its degree.
SplatCloud cloud_of(const DegreeBucket& bucket, const SplatCloud& cloud);

}  // namespace fluxgs::io
