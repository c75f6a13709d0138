// Between the frame of a SplatCloud (y down, z forward: INRIA's .ply) and that of glTF (y up): half
// a turn about z, x → −x, y → −y. It is its own inverse, and exact: only signs change. Other
// converters (PlayCanvas splat-transform) use the same turn.
#pragma once

#include <cstddef>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

/// A position from the cloud to glTF; its own inverse.
template <class T>
glm::vec<3, T> turn_position(const glm::vec<3, T>& p) {
  return {-p.x, -p.y, p.z};
}

/// The product (0,0,0,1)·q from the cloud to glTF; q and −q are the same rotation.
inline glm::quat turn_to_gltf(const glm::quat& q) { return glm::quat(-q.z, -q.y, q.x, q.w); }
/// The inverse of turn_to_gltf().
inline glm::quat turn_from_gltf(const glm::quat& q) { return glm::quat(q.z, q.y, -q.x, -q.w); }

/// Sign of a basis function under the turn: minus for odd orders m. Index 0 is the first function
/// of degree 1.
inline float turn_sign(std::size_t basis) {
  constexpr float kSigns[15] = {-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1};
  return kSigns[basis];
}

/// The splats [begin, end) of a cloud, which are of a degree up to its own, from either frame into
/// the other (a quaternion may change its sign). Coefficients beyond the degree stay as they are.
inline void turn_splats(SplatCloud& cloud, std::size_t begin, std::size_t end, int degree) {
  const auto stored = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const auto rest = static_cast<std::size_t>(sh_rest_count(degree));
  for (std::size_t i = begin; i < end; ++i) {
    cloud.positions[i] = turn_position(cloud.positions[i]);
    cloud.rotations[i] = turn_from_gltf(cloud.rotations[i]);
    for (std::size_t k = 0; k < rest; ++k) cloud.sh_rest[stored * i + k] *= turn_sign(k);
  }
}

/// The whole cloud, likewise.
inline void turn_cloud(SplatCloud& cloud) { turn_splats(cloud, 0, cloud.size(), cloud.sh_degree); }

}  // namespace fluxgs::io
