// The arrays of a training's state as bytes: little-endian, as they lie in a checkpoint.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trainer/model/train_state.h"

namespace fluxgs {

/// Shapes of the arrays.
struct StateLayout {
  struct Attached {
    std::string name;
    int rows = 0;  ///< 1…1000
    bool moments = false;
  };
  struct PhaseValues {
    std::string name;
    std::uint64_t count = 0;  ///< at most 2²⁴
  };
  std::uint64_t splats = 0;
  int sh_degree = 0;  ///< 0…3
  bool own_degrees = false;
  std::vector<Attached> attached = {};
  std::vector<PhaseValues> phase_values = {};

  /// Bytes of all arrays; none for shapes out of range, or more splats than can be (2⁴⁰).
  std::optional<std::uint64_t> size() const;
};

StateLayout layout_of(const TrainState& state);

void append_state(std::vector<std::byte>& out, const TrainState& state);

/// Fills the arrays of `state` from layout.size() bytes.
void take_state(const std::byte* in, const StateLayout& layout, TrainState& state);

}  // namespace fluxgs
