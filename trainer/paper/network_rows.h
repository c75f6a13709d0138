// The networks' input rows from the trainer's parameters: networks::psi_row() and phi_row() of the
// splat in glTF's frame, with its canonical rotation.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "fluxgs/networks/appearance.h"
#include "trainer/core/parameters.h"

namespace fluxgs {

/// One splat's latents, first-order SH or their gradient, in the order of the columns.
using ShRow = std::array<float, networks::kShColumns>;

/// Row `first_row + k` of a PlanarFloats at splat i is entry k. The signs are those that the turn
/// into glTF's frame and back changes: of SH coefficients, and of E.
ShRow turned_sh(const PlanarFloats& from, int first_row, std::size_t i);
void put_turned_sh(const ShRow& sh, PlanarFloats& to, int first_row, std::size_t i);
ShRow turned_energy(const PlanarFloats& from, std::size_t i);
void put_turned_energy(const ShRow& energy, PlanarFloats& to, std::size_t i);

/// Splat i's row, or zeros where an entry is not finite, so that one bad splat does no harm to the
/// weights. `sh` is c′ in glTF's frame.
void put_psi_row(const networks::Normalisation& normalisation, const PlanarFloats& parameters,
                 const PlanarFloats& latents, std::size_t i, float* row);
void put_phi_row(const networks::Normalisation& normalisation, const PlanarFloats& parameters,
                 const ShRow& sh, std::size_t i, float* row);

/// True if an entry of a row is inside of the limits; at them its derivative is 0.
inline bool moves(float entry) { return std::abs(entry) < networks::kInputLimit; }

}  // namespace fluxgs
