// Inertia: a drag that fades after the finger has left.
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec2.hpp>

namespace fluxgs::camera {

/// A drag without a finger. Its velocity decays exponentially and is cut off where nobody sees it,
/// at a time that the velocity alone decides: the path does not depend on how time is divided into
/// frames (but for rounding), and ends.
struct Glide {
  glm::dvec2 velocity{0.0};  ///< px/s
};

struct GlideOptions {
  double decay = 0.22;       ///< seconds in which the velocity falls to 1/e
  double slowest = 4.0;      ///< px/s; below, the glide is over
  double fastest = 20000.0;  ///< px/s; faster throws count as this fast
};

/// A glide from a pointer's velocity; at rest where that is below the slowest or not finite.
Glide thrown(const glm::dvec2& velocity, const GlideOptions& options = {});

inline bool moving(const Glide& glide) { return glide.velocity != glm::dvec2(0.0); }

/// Lets time pass; how far the drag went in it, in pixels.
glm::dvec2 advance(Glide& glide, double seconds, const GlideOptions& options = {});

/// The last positions of a pointer that is down.
struct PointerTrail {
  struct Sample {
    double time = 0;
    glm::dvec2 position{0.0};
  };
  std::array<Sample, 16> samples;  ///< a ring
  std::size_t count = 0;           ///< ever added
};

/// Adds a position; times do not decrease.
void add(PointerTrail& trail, double time, const glm::dvec2& position);

/// The mean velocity in px/s over the last tenth of a second before `now`: none where the pointer
/// rested before it was lifted.
glm::dvec2 velocity(const PointerTrail& trail, double now);

}  // namespace fluxgs::camera
