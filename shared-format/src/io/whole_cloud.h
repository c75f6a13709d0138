// Splats handed on part by part, and put together again.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "cloud/cloud_memory.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"

namespace fluxgs::io {

/// All splats in one cloud.
class WholeCloud final : public SplatSink {
 public:
  explicit WholeCloud(const std::string& name) : name_(name) {}
  Expected<int> begin(const ComingSplats& coming) override;
  Expected<void> take(SplatCloud& part) override;

  /// The cloud, once, with this filter.
  SplatCloud finish(const ScreenFilter& filter);

 private:
  const std::string& name_;
  SplatCloud cloud_;
  std::size_t count_ = 0;
};

/// Calls `read`, which gives its splats to a sink, and puts them into its result.
template <class Read>
Expected<SceneFile> read_whole(const std::string& name, const Read& read) {
  WholeCloud whole(name);
  Expected<SceneFile> scene = read(whole);
  if (scene) scene->cloud = whole.finish(scene->cloud.filter);
  return scene;
}

/// Gives `coming.count` splats to a sink: fill(first, part) fills a part, which has its size and
/// the degree wanted, with those of the file from `first` on. Those with a NaN or infinity are left
/// out and counted in `scene`, which gets the degree too.
template <class Fill>
Expected<void> hand_on(const ComingSplats& coming, int wanted_degree, const std::string& name,
                       SplatSink& sink, SceneFile& scene, const Fill& fill) {
  scene.cloud.sh_degree = wanted_degree;
  auto part = allocate_cloud(std::min(coming.count, kSplatsOfAPart), wanted_degree, name);
  if (!part) return std::unexpected(part.error());
  for (std::size_t first = 0; first < coming.count; first += kSplatsOfAPart) {
    part->resize(std::min(kSplatsOfAPart, coming.count - first));
    if (Expected<void> filled = fill(first, *part); !filled) return filled;
    scene.dropped += drop_non_finite(*part);
    if (auto taken = sink.take(*part); !taken) return taken;
  }
  return {};
}

}  // namespace fluxgs::io
