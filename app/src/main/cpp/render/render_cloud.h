// A scene as it is kept for drawing: like a SplatCloud, but the harmonics are half floats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fluxgs/splat_cloud.h"
#include "fluxgs/splat_degree.h"

namespace fluxgs::render {

/// Splats whose harmonics are rounded as they are on the GPU (scene_packing.h), where three of four
/// numbers of a splat of degree 3 are harmonics.
struct RenderCloud {
  SplatCloud base;                ///< all but the harmonics: its degree is 0
  int sh_degree = 0;              ///< 0…3
  std::vector<std::uint16_t> sh;  ///< half floats: [splat][coefficient] RGB, degrees 1…sh_degree

  std::size_t file_splats = 0;  ///< finite ones of the file, of which these may be a part
  int file_sh_degree = 0;       ///< of the file

  RenderCloud() = default;
  /// All of a cloud, which may have splats that cannot be drawn.
  RenderCloud(const SplatCloud& cloud);  // NOLINT: a conversion
  explicit RenderCloud(SplatCloud&& cloud);

  std::size_t size() const { return base.size(); }
  /// True if nothing of the file was left out.
  bool is_whole() const { return size() == file_splats && sh_degree == file_sh_degree; }
  /// Half floats of a splat.
  std::size_t sh_size() const { return 3 * static_cast<std::size_t>(sh_rest_count(sh_degree)); }
};

/// Bytes of a splat.
constexpr std::size_t render_cloud_bytes(int sh_degree) {
  return sizeof(float) * 14 +
         sizeof(std::uint16_t) * 3 * static_cast<std::size_t>(sh_rest_count(sh_degree));
}

/// The same with floats.
SplatCloud splat_cloud_of(const RenderCloud& cloud);

/// Makes room for all splats to come, of which append() adds some.
void reserve(RenderCloud& cloud, std::size_t count);

/// Adds splat i of a cloud, of the degree of `to` or a lower one.
void append(const SplatCloud& from, std::size_t i, RenderCloud& to);

/// The degree that splat i needs: the highest of which it has a coefficient that is not zero.
int sh_degree_of(const RenderCloud& cloud, std::size_t i);

/// True if splats next to each other in the cloud mostly lie next to each other in space, as far as
/// a few thousand of them show.
bool lies_in_order(const SplatCloud& cloud);

/// Puts the splats into the order of morton_order(), unless they lie in order: what a frame draws
/// one after the other then lies together in memory. Needs 28 bytes a splat meanwhile.
void put_in_order(RenderCloud& cloud);

/// All of a finite cloud, in order.
RenderCloud cloud_to_draw(SplatCloud&& cloud);

}  // namespace fluxgs::render
