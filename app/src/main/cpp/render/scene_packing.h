// Layout of a splat cloud in graphics memory, without GL calls.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fluxgs/splat_degree.h"
#include "render/render_cloud.h"
#include "render/scene_constants.h"

namespace fluxgs::render {

/// Splats with larger numbers are not drawn: they cannot be projected in float32 without overflow.
inline constexpr float kLargestDrawable = 1e15F;

/// Words of four half floats that hold the coefficients of degrees 1…degree of a splat: groups of
/// four, three words each.
constexpr std::uint32_t sh_stride(int degree) {
  return 3U * static_cast<std::uint32_t>((sh_rest_count(degree) + 3) / 4);
}

/// Number of splats of a scene.
std::uint64_t count_of(const DegreeCounts& splats);

/// Bytes of the coefficients of a scene: each splat takes those of its own degree.
std::uint64_t sh_bytes(const DegreeCounts& splats);

/// So many splats of a scene (all, if it has fewer), those of high degrees first: whichever they
/// are, they take no more memory than these.
DegreeCounts largest_of(const DegreeCounts& scene, std::uint64_t count);

/// The same splats without the harmonics beyond a degree.
DegreeCounts limited(const DegreeCounts& scene, int sh_degree);

/// Number of splats of largest_of() whose coefficients fit into that many bytes.
std::uint64_t with_sh_in(std::uint64_t bytes, const DegreeCounts& scene);

/// Splats as the projection pass reads them (shaders/project.comp). The coefficients beyond the
/// constant one are half floats, as the colour is that comes of them: they are three quarters of a
/// splat of degree 3, and halves take a hundredth of a level of 255 from its colour.
struct PackedSplats {
  std::vector<std::array<float, 4>> geometry;  ///< 4 per splat; the last float is a uint
  std::vector<std::uint64_t> sh;               ///< sh_stride(its degree) per splat
};

/// Bytes of a splat in PackedSplats::geometry.
inline constexpr std::uint64_t kGeometryBytes = 4 * sizeof(PackedSplats::geometry[0]);

constexpr std::size_t kSplatsPacked = 16384;  ///< at once, that pay: 2.6 MB at degree 3

/// Packs a scene part by part: there is not always room for the whole of it a second time. The
/// cloud must be sound (check_cloud()) and, like the indices, outlive the packer.
class ScenePacker {
 public:
  /// Those splats of the cloud, in that order; all of them where none are given. Without the
  /// harmonics beyond a degree. Relative to the median position the coordinates of a scene that
  /// lies far from the world's origin keep their bits.
  explicit ScenePacker(const RenderCloud& cloud,
                       std::optional<std::span<const std::uint32_t>> splats = {},
                       int max_sh_degree = kMaxShDegree);
  explicit ScenePacker(RenderCloud&&) = delete;

  const SceneConstants& constants() const { return constants_; }
  const DegreeCounts& degrees() const { return degrees_; }
  /// Splats with an attribute that is not finite or is beyond 1e15. They keep their index and get
  /// no opacity.
  std::size_t undrawable() const { return undrawable_; }

  /// The next splats, `most` at most; nothing after the last one.
  void next(std::size_t most, PackedSplats& part);

 private:
  std::size_t splat(std::size_t k) const { return splats_ ? (*splats_)[k] : k; }
  glm::vec3 position(std::size_t i) const {
    return glm::vec3(glm::dvec3(cloud_.base.positions[i]) - constants_.origin);
  }
  void find_median();
  void find_box();
  void pack_geometry(std::size_t i, std::array<float, 4>* out) const;
  void pack_sh(std::size_t i, int degree, std::uint64_t* out) const;

  const RenderCloud& cloud_;
  std::optional<std::span<const std::uint32_t>> splats_;
  std::vector<bool> drawable_;        // by place, not by index in the cloud
  std::vector<std::uint8_t> degree_;  // of SH, by place
  SceneConstants constants_;
  DegreeCounts degrees_{};
  std::size_t undrawable_ = 0;
  std::size_t packed_ = 0;  // splats so far
  std::size_t sh_ = 0;      // words so far
};

/// Appends the position of each of these splats, relative to the scene's origin; NaN for undrawable
/// ones.
void add_positions(const PackedSplats& part, std::vector<glm::vec3>& positions);

/// Hands `take` the parts of a scene, kSplatsPacked splats each, and adds their positions to
/// `positions` unless that is null. Precondition: the packer has given none yet.
template <class Take>
void pack_in_parts(ScenePacker& packer, std::vector<glm::vec3>* positions, Take&& take) {
  const std::size_t count = packer.constants().count;
  if (positions != nullptr) positions->reserve(count);
  PackedSplats part;
  for (std::size_t done = 0; done < count; done += kSplatsPacked) {
    packer.next(kSplatsPacked, part);
    take(part);
    if (positions != nullptr) add_positions(part, *positions);
  }
}

}  // namespace fluxgs::render
