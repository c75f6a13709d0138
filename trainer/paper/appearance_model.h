// The networks that make a scene's colours after the SH reduction (paper, "Monte Carlo Specular
// Energy Aggregator" and "Gaussian Attribute Awareness"; formulas, columns and rows:
// fluxgs/networks/appearance.h):
//
//   c′ = Ψ(E, f(μ̂)), or c′ itself is trained;   c = c′ + Φ(μ̂, ŝ, r, o, ĉ′), or c = c′
//
// The values trained for each splat, E or c′, are its latents: a PlanarFloats of
// networks::kShColumns rows in the frame of the parameters; E: E_mag (r, g, b), E_dir x, y, z (r,
// g, b each); c′: in the order of the rows sh_dc and sh_rest.
//
// The networks themselves know the scene as a compact file has it: in glTF's frame, with canonical
// rotations (fluxgs/io/compact_glb.h), so that they are stored as they were trained.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/networks/appearance.h"
#include "trainer/core/parameters.h"
#include "trainer/paper/trainable_mlp.h"

namespace fluxgs {

/// Hidden layers as in the paper's supplement, "Additional Implementation" (which speaks of two
/// networks of Ψ's size).
inline const std::vector<int> kPsiSizes = {networks::kPsiColumns, 64, networks::kShColumns};
inline const std::vector<int> kPhiSizes = {networks::kPhiColumns, 128, 64, 32,
                                           networks::kShColumns};

/// Learning rates of the networks by the iterations since the SH reduction.
struct NetworkRates {
  double psi = 0.01;
  int psi_warmup = 100;     ///< iterations in which Ψ's rate grows linearly to its full value
  double psi_decay = 0.33;  ///< factor at each of the following iterations
  std::array<int, 3> psi_decay_at = {1000, 3500, 6000};
  double phi = 1e-3;  ///< constant

  double psi_at(int step) const;  ///< of step `step`, counted from 0
};

/// Everything of the networks that a checkpoint holds.
struct AppearanceModel {
  networks::Normalisation normalisation = {};  ///< of the scene in glTF's frame; fixed
  std::optional<TrainableMlp> psi = {}, phi = {};
};

/// Ψ of random weights, Φ as the constant 0 ("zero-initialized", section "Gaussian Attribute
/// Awareness"); each where it is wanted. The seed alone decides the weights.
AppearanceModel make_appearance_model(bool psi, bool phi,
                                      const networks::Normalisation& normalisation,
                                      std::uint64_t seed);

/// The constants for parameters whose rows sh_dc and sh_rest hold c′ (degree 1 or more): those of
/// their finite splats, turned into glTF's frame.
networks::Normalisation measure_normalisation(const PlanarFloats& parameters);

/// The model as one list of values for checkpoints, without loss, and back. Which networks it has
/// is not part of it. An error if the list is not of the right length or its normalisation is not
/// finite.
std::vector<float> to_floats(const AppearanceModel& model);
std::size_t appearance_floats(bool psi, bool phi);  ///< how many
Expected<AppearanceModel> model_from_floats(bool psi, bool phi, std::span<const float> floats);

}  // namespace fluxgs
