#include "trainer/core/isa.h"

#include <cstdlib>

namespace fluxgs {

std::string_view name_of(Isa isa) {
  switch (isa) {
    case Isa::avx2:
      return "avx2";
    case Isa::avx512:
      return "avx512";
    case Isa::baseline:
      break;
  }
  return "baseline";
}

std::vector<Isa> available_isas() {
  std::vector<Isa> isas{Isa::baseline};
#ifdef FLUXGS_HAVE_AVX2
  // The features of x86-64-v3 and -v4 that the kernels use
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("aes") &&
      __builtin_cpu_supports("pclmul"))
    isas.push_back(Isa::avx2);
#endif
#ifdef FLUXGS_HAVE_AVX512
  if (isas.back() == Isa::avx2 && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    isas.push_back(Isa::avx512);
#endif
  return isas;
}

Isa best_isa() {
  static const Isa best = [] {
    const std::vector<Isa> isas = available_isas();
    const char* wanted = std::getenv("FLUXGS_ISA");
    for (Isa isa : isas)
      if (wanted && name_of(isa) == wanted) return isa;
    return isas.back();
  }();
  return best;
}

}  // namespace fluxgs
