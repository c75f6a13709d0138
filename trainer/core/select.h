// Choice of a table of kernels at run time: each instruction set's namespace has a variable of the
// same name, defined in that set's objects.
#pragma once

#include "trainer/core/isa.h"

/// Declares `TYPE VARIABLE` in every instruction set's namespace and defines `const TYPE&
/// FUNCTION(Isa)`, to be used inside namespace fluxgs.
#ifdef FLUXGS_HAVE_AVX512
#define FLUXGS_SELECT_KERNELS(TYPE, VARIABLE, FUNCTION) \
  namespace baseline {                                  \
  extern const TYPE VARIABLE;                           \
  }                                                     \
  namespace avx2 {                                      \
  extern const TYPE VARIABLE;                           \
  }                                                     \
  namespace avx512 {                                    \
  extern const TYPE VARIABLE;                           \
  }                                                     \
  const TYPE& FUNCTION(Isa isa) {                       \
    if (isa == Isa::avx512) return avx512::VARIABLE;    \
    if (isa == Isa::avx2) return avx2::VARIABLE;        \
    return baseline::VARIABLE;                          \
  }
#else
#define FLUXGS_SELECT_KERNELS(TYPE, VARIABLE, FUNCTION) \
  namespace baseline {                                  \
  extern const TYPE VARIABLE;                           \
  }                                                     \
  const TYPE& FUNCTION(Isa) { return baseline::VARIABLE; }
#endif
