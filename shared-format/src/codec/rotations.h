// Rotations as they are stored: of the four that differ by half turns about the splat's own axes,
// which leave its covariance as it is, the one with the largest |w|, with w > 0. Its x, y, z are at
// most ½·√3 long, and w, ½ at least, follows from them.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

namespace fluxgs::codec {

glm::vec3 reduced_rotation(const glm::quat& rotation);  ///< x, y, z
glm::quat full_rotation(const glm::vec3& xyz);          ///< back, also from quantized ones

}  // namespace fluxgs::codec
