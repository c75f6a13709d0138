// Putting splats into drawing order.
#pragma once

#include <cstdint>

#include "gl/buffer.h"

namespace fluxgs::sort {

/// A key that means: this splat is not drawn.
inline constexpr std::uint32_t kDropped = 0xFFFFFFFFU;

/// Sorts on the GPU without the CPU learning the result. The interface of every sorter.
class Sorter {
 public:
  virtual ~Sorter() = default;

  /// Makes room for that many keys; nothing is allocated by sort() afterwards. `spare` entries
  /// more are kept at the end of order() for the caller's use.
  virtual Expected<void> reserve(std::uint32_t count, std::uint32_t spare) = 0;

  /// Enqueues the sort of keys[0 … count), 32-bit unsigned numbers, and the barrier that lets
  /// shaders read the result. Precondition: count ≤ what was reserved.
  virtual void sort(const gl::Buffer& keys, std::uint32_t count) = 0;

  /// The indices of the keys that are not kDropped, the largest key first; among equal keys the
  /// largest index first. With depths as keys that is back to front, and of two splats at one
  /// depth the one with the smaller index lies in front.
  virtual const gl::Buffer& order() const = 0;

  /// A buffer whose first 32-bit word is the number of valid entries of order().
  virtual const gl::Buffer& count() const = 0;
};

}  // namespace fluxgs::sort
