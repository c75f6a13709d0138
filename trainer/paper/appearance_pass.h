// Forward and backward pass of the networks for the splats of one view. The networks' other inputs
// (position, scale, rotation, opacity) are taken as constants: their gradients are those of the
// rasteriser alone.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "trainer/core/isa.h"
#include "trainer/core/parallel.h"
#include "trainer/paper/appearance_model.h"

namespace fluxgs {

/// Memory and optimiser of the networks. `threads` must outlive it. Same bytes for any number
/// of threads. Keeps about 800 bytes for each splat of the largest view so far.
class AppearancePass {
 public:
  explicit AppearancePass(const Threads& threads, Isa isa = best_isa());

  /// Writes c of the listed splats to rows sh_dc and sh_rest (degree 1) of `colors`, at the columns
  /// of these splats; nothing else of it is touched, and it may be the parameters themselves.
  /// Every splat at most once, in any order (ascending is fastest).
  void shade(const AppearanceModel& model, const PlanarFloats& parameters,
             const PlanarFloats& latents, std::span<const std::uint32_t> splats,
             PlanarFloats& colors);

  /// For the splats, model, parameters and latents of the last shade(): from ∂L/∂c (rows as the
  /// parameters) to ∂L/∂latents (networks::kShColumns rows), written at their columns, and to the
  /// weights, kept for step(). Where `visible` is 0 the gradient counts as zero; where it is not
  /// finite too, and is counted.
  void backpropagate(const AppearanceModel& model, const PlanarFloats& gradient,
                     const std::vector<std::uint8_t>& visible, PlanarFloats& latent_gradient);

  /// One step of Adam on the networks with the gradients of the last backpropagate().
  void step(AppearanceModel& model, const NetworkRates& rates, const AdamConstants& constants);

  /// Gradients of splats and weights that were not finite and therefore skipped.
  std::uint64_t rejected_gradients() const { return rejected_; }

 private:
  /// Room of one network: what its forward pass leaves for the backward pass, and the gradients of
  /// its weights, of groups of splats and their sum.
  struct Room {
    MlpBatch batch;
    MlpTransposed transposed;
    std::vector<MlpMatrices> groups;
    MlpMatrices gradient;
  };

  void prepare(const std::optional<TrainableMlp>& network, int first_input, Room& room) const;
  void backpropagate_piece(const AppearanceModel& model, const PlanarFloats& gradient,
                           const std::vector<std::uint8_t>& visible, std::size_t begin,
                           std::size_t end, PlanarFloats& latent_gradient);
  void add_groups(const std::optional<TrainableMlp>& network, Room& room) const;

  const Threads& threads_;
  const MlpKernels& kernels_;
  const AdamKernels& adam_;
  std::vector<std::uint32_t> splats_;
  Room psi_, phi_;
  std::atomic<std::uint64_t> rejected_ = 0;
};

/// c of every splat as by shade(), without keeping anything for a backward pass.
void bake(const AppearanceModel& model, const PlanarFloats& parameters, const PlanarFloats& latents,
          const Threads& threads, PlanarFloats& colors, Isa isa = best_isa());

}  // namespace fluxgs
