// Putting splats into drawing order.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "gl/buffer.h"
#include "gl/texel_array.h"
#include "sort/depth_keys.h"

namespace fluxgs::sort {

/// Everything that a frame's order depends on.
struct SortView {
  glm::dvec3 centre{0.0};   ///< the camera's, relative to the scene's origin
  glm::dvec3 forward{0.0};  ///< unit vector along which depth is measured
  double near_plane = 0;    ///< nothing nearer is drawn
  DepthKeys keys;
  bool operator==(const SortView&) const = default;
};

/// The place of an order that was made on the CPU.
enum class OrderPlace {
  buffers,  ///< Sorter::order() and count()
  texture,  ///< Sorter::order_texture(), for drivers without storage buffers
};

struct OrderTexture {
  gl::TexelArray indices;   ///< GL_R32UI
  std::uint32_t count = 0;  ///< valid ones
};

/// The interface of every sorter: two on the CPU, which know the positions, and one on the GPU,
/// which sorts the keys that the projection pass wrote.
class Sorter {
 public:
  virtual ~Sorter() = default;

  /// True if set_scene() wants the positions.
  virtual bool needs_positions() const = 0;

  /// Makes room for `count` splats; nothing is allocated by the functions below afterwards. `spare`
  /// entries more are kept at the end of order() for the caller's use. `positions` are relative to
  /// the scene's origin, one a splat, not finite for splats that are never drawn; empty where
  /// needs_positions() is false.
  virtual Expected<void> set_scene(std::uint32_t count, std::uint32_t spare,
                                   std::vector<glm::vec3> positions) = 0;

  /// Sorts the splats of the scene for this view, or lets a thread begin to. `keys` holds a depth
  /// key or kDropped for every splat; null will do where needs_positions() is true. What order()
  /// and count() hold then can be used by shaders.
  virtual void sort(const SortView& view, const gl::Buffer* keys) = 0;

  /// Makes an order that has become ready since available; to be called once a frame.
  virtual void collect() {}

  /// True if order() is that of the last view.
  virtual bool is_current() const { return true; }

  /// Seconds from asking for the order that is shown until it was shown; 0 where sort() makes it.
  virtual double latency() const { return 0; }

  /// Waits until order() is that of the last view.
  virtual void finish() {}

  /// The indices of the splats to be drawn, the largest depth first; among equal keys the largest
  /// index first, so that of two splats at one depth the one with the smaller index lies in front.
  /// The CPU's sorters list splats outside of the image too.
  virtual const gl::Buffer& order() const = 0;

  /// A buffer whose first 32-bit word is the number of valid entries of order().
  virtual const gl::Buffer& count() const = 0;

  /// The order in place of order() and count(), which then are empty; null with
  /// OrderPlace::buffers.
  virtual const OrderTexture* order_texture() const { return nullptr; }
};

}  // namespace fluxgs::sort
