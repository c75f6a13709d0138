#include "trainer/paper/latent_adam.h"

namespace fluxgs {
namespace {

constexpr std::size_t kLatentPiece = 4096;  // splats

}  // namespace

void latent_adam_step(PlanarFloats& latents, AdamState& state, const PlanarFloats& gradient,
                      const std::vector<std::uint8_t>& visible, const LatentRates& rates,
                      const AdamStep& adam, const Threads& threads) {
  threads.for_pieces(latents.size(), kLatentPiece, [&](std::size_t begin, std::size_t end) {
    for (int r = 0; r < latents.rows(); ++r)
      adam.run({latents.row(r), state.first.row(r), state.second.row(r), gradient.row(r),
                visible.data(), r < 3 ? rates.constant : rates.directional},
               begin, end);
  });
}

}  // namespace fluxgs
