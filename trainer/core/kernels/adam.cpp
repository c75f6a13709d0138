#include "trainer/core/adam_kernels.h"
#include "trainer/core/lanes.h"

namespace fluxgs::FLUXGS_ISA {

void adam(const AdamArgs& a, std::size_t begin, std::size_t end) {
  const Lanes beta1(a.beta1), beta2(a.beta2), rest1(1.0f - a.beta1), rest2(1.0f - a.beta2);
  const Lanes step(a.step), correction(a.second_correction), epsilon(a.epsilon);
  for (std::size_t i = begin; i < end; i += static_cast<std::size_t>(kLanes)) {
    const LaneMask visible = nonzero(a.visible + i);
    if (!any(visible)) continue;
    const Lanes g = Lanes::load(a.gradient + i);
    const Lanes old_first = Lanes::load(a.first + i), old_second = Lanes::load(a.second + i);
    const Lanes first = fma(beta1, old_first, rest1 * g);
    const Lanes second = fma(beta2, old_second, rest2 * g * g);
    const Lanes change = step * first / (sqrt(second * correction) + epsilon);
    const Lanes old = Lanes::load(a.parameter + i);
    select(visible, old - change, old).store(a.parameter + i);
    select(visible, first, old_first).store(a.first + i);
    select(visible, second, old_second).store(a.second + i);
  }
}

extern const AdamKernels kAdamKernels;
const AdamKernels kAdamKernels{adam};

}  // namespace fluxgs::FLUXGS_ISA
