// Where readers put splats: into one cloud, or part by part into whatever holds them more cheaply.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// What a reader knows before it takes memory for splats.
struct ComingSplats {
  std::size_t count = 0;   ///< splats with a NaN or infinity included, which do not come
  int sh_degree = 0;       ///< the highest
  std::uint64_t held = 0;  ///< about how many bytes the reader itself will hold beside the parts
};

/// Splats that a reader hands on at once, at most; formats that are decoded as a whole hand on
/// more.
inline constexpr std::size_t kSplatsOfAPart = 16384;

/// Takes the splats of a file in its order. After an error, and when the reader fails, what came
/// is to be thrown away, but for whole chunks.
class SplatSink {
 public:
  SplatSink() = default;
  SplatSink(const SplatSink&) = delete;
  SplatSink& operator=(const SplatSink&) = delete;
  virtual ~SplatSink() = default;

  /// Once, before the first part. Returns the degree up to which harmonics are wanted.
  virtual Expected<int> begin(const ComingSplats& coming) = 0;

  /// Finite splats, of the degree that begin() returned or a lower one: then the bands that are
  /// missing are zeros. The part may be moved from.
  virtual Expected<void> take(SplatCloud& part) = 0;

  /// All of a chunk was taken, and more are to come: a coarse picture of the whole scene
  /// (SceneFile::chunks). `so_far` has the start view, the filter and the chunks.
  virtual void chunk_came([[maybe_unused]] const SceneFile& so_far) {}
};

}  // namespace fluxgs
