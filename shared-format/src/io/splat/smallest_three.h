// Rotations as formats store them that leave out the largest component of the quaternion.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace fluxgs::io {

struct SmallestThree {
  std::size_t largest;           ///< index of the component left out, which is positive
  std::array<double, 3> others;  ///< of the unit quaternion, −√½…√½, in order
};

/// `q`: a quaternion of any length, whose real part is q[real]; zeros are the identity.
inline SmallestThree to_smallest_three(std::array<double, 4> q, std::size_t real) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (length == 0) q[real] = 1;
  SmallestThree result{};
  result.largest = static_cast<std::size_t>(
      std::ranges::max_element(q, {}, [](double c) { return std::abs(c); }) - q.begin());
  // q and −q are the same rotation
  const double unit = std::copysign(length == 0 ? 1 : 1 / length, q[result.largest]);
  std::size_t to = 0;
  for (std::size_t i = 0; i < q.size(); ++i)
    if (i != result.largest) result.others[to++] = q[i] * unit;
  return result;
}

}  // namespace fluxgs::io
