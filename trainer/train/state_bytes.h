// The arrays of a training's state as bytes: little-endian floats, as they lie in a checkpoint.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/model/train_state.h"

namespace fluxgs {

/// Which arrays there are.
struct StateLayout {
  std::uint64_t splats = 0;
  int sh_degree = 0;  ///< 0…3
  bool own_degrees = false, psi = false, phi = false, rounding = false;

  bool networks() const { return psi || phi; }
  std::size_t model_floats() const;
  /// Bytes of all arrays; none for more splats than can be (2⁴⁰).
  std::optional<std::uint64_t> size() const;
};

StateLayout layout_of(const TrainState& state);

void append_state(std::vector<std::byte>& out, const TrainState& state);

/// Fills the arrays of `state` from layout.size() bytes; its `rounding` has a value already where
/// the layout says so. An error if the networks' numbers make none.
Expected<void> take_state(const std::byte* in, const StateLayout& layout, TrainState& state);

}  // namespace fluxgs
