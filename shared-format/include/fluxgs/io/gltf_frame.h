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

/// The whole cloud, from either frame into the other (a quaternion may change its sign).
inline void turn_cloud(SplatCloud& cloud) {
  for (glm::vec3& p : cloud.positions) p = turn_position(p);
  for (glm::quat& q : cloud.rotations) q = turn_from_gltf(q);
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t i = 0; i < cloud.sh_rest.size(); ++i) cloud.sh_rest[i] *= turn_sign(i % rest);
}

}  // namespace fluxgs::io
