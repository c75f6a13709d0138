// Functions that what is decoded depends on, with the same bits from every C library: float
// versions differ in their last bits (glibc, musl and bionic do), double ones rounded to float
// agree but for one argument in a hundred million.
#pragma once

#include <cmath>

namespace fluxgs::codec {

inline float portable_exp(float x) { return static_cast<float>(std::exp(double{x})); }
inline float portable_log(float x) { return static_cast<float>(std::log(double{x})); }

}  // namespace fluxgs::codec
