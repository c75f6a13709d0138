#include "trainer/appearance/latent_adam.h"

#include <cmath>

namespace fluxgs {
namespace {

constexpr std::size_t kPiece = 4096;  // splats

}  // namespace

void latent_adam_step(PlanarFloats& latents, AdamState& state, const PlanarFloats& gradient,
                      const std::vector<std::uint8_t>& visible, const LatentRates& rates,
                      const AdamConstants& constants, int step, const Threads& threads,
                      const AdamKernels& kernels) {
  const double correction1 = 1 / (1 - std::pow(constants.beta1, step));
  const double correction2 = 1 / (1 - std::pow(constants.beta2, step));
  threads.for_pieces(latents.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    for (int r = 0; r < latents.rows(); ++r) {
      const double rate = r < 3 ? rates.constant : rates.directional;
      kernels.adam({latents.row(r), state.first.row(r), state.second.row(r), gradient.row(r),
                    visible.data(), static_cast<float>(rate * correction1),
                    static_cast<float>(correction2), static_cast<float>(constants.beta1),
                    static_cast<float>(constants.beta2), static_cast<float>(constants.epsilon)},
                   begin, end);
    }
  });
}

}  // namespace fluxgs
