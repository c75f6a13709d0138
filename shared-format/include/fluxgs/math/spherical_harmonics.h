// Real spherical harmonics (SH) of degrees 0…3 in the order and with the signs that 3DGS scenes use
// (Kerbl et al. 2023; Ramamoorthi & Hanrahan 2001 for the polynomials).
#pragma once

#include "fluxgs/math/scalar.h"
#include "fluxgs/math/vec.h"

namespace fluxgs::math {

inline constexpr double kSh0 = 0.28209479177387814;  ///< basis function of degree 0
inline constexpr double kSh1 = 0.4886025119029199;   ///< factor of degree 1
/// Factors of degree 2.
inline constexpr double kSh2[] = {1.0925484305920792, -1.0925484305920792, 0.31539156525252005,
                                  -1.0925484305920792, 0.5462742152960396};
/// Factors of degree 3.
inline constexpr double kSh3[] = {-0.5900435899266435, 2.890611442640554,   -0.4570457994644658,
                                  0.3731763325901154,  -0.4570457994644658, 1.445305721320277,
                                  -0.5900435899266435};

/// Basis functions 1…(degree+1)²−1 at a unit direction; the constant one is kSh0.
/// `basis` must hold sh_rest_count(degree) entries.
template <class T>
void sh_basis(int degree, const Vec3<T>& d, T* basis) {
  if (degree < 1) return;
  const T x = d.x, y = d.y, z = d.z;
  basis[0] = T(-kSh1) * y;
  basis[1] = T(kSh1) * z;
  basis[2] = T(-kSh1) * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z;
  basis[3] = T(kSh2[0]) * (x * y);
  basis[4] = T(kSh2[1]) * (y * z);
  basis[5] = T(kSh2[2]) * (T(2) * zz - xx - yy);
  basis[6] = T(kSh2[3]) * (x * z);
  basis[7] = T(kSh2[4]) * (xx - yy);
  if (degree < 3) return;
  basis[8] = T(kSh3[0]) * y * (T(3) * xx - yy);
  basis[9] = T(kSh3[1]) * (x * y) * z;
  basis[10] = T(kSh3[2]) * y * (T(4) * zz - xx - yy);
  basis[11] = T(kSh3[3]) * z * (T(2) * zz - T(3) * xx - T(3) * yy);
  basis[12] = T(kSh3[4]) * x * (T(4) * zz - xx - yy);
  basis[13] = T(kSh3[5]) * z * (xx - yy);
  basis[14] = T(kSh3[6]) * x * (xx - T(3) * yy);
}

/// The gradients of the polynomials above with respect to (x, y, z), taken as free variables.
/// `gradient` must hold sh_rest_count(degree) entries.
template <class T>
void sh_basis_gradient(int degree, const Vec3<T>& d, Vec3<T>* gradient) {
  if (degree < 1) return;
  const T x = d.x, y = d.y, z = d.z, zero(0);
  gradient[0] = {zero, T(-kSh1), zero};
  gradient[1] = {zero, zero, T(kSh1)};
  gradient[2] = {T(-kSh1), zero, zero};
  if (degree < 2) return;
  const T c20(kSh2[0]), c21(kSh2[1]), c22(kSh2[2]), c23(kSh2[3]), c24(kSh2[4]);
  gradient[3] = {c20 * y, c20 * x, zero};
  gradient[4] = {zero, c21 * z, c21 * y};
  gradient[5] = {T(-2) * c22 * x, T(-2) * c22 * y, T(4) * c22 * z};
  gradient[6] = {c23 * z, zero, c23 * x};
  gradient[7] = {T(2) * c24 * x, T(-2) * c24 * y, zero};
  if (degree < 3) return;
  const T xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z;
  const T c30(kSh3[0]), c31(kSh3[1]), c32(kSh3[2]), c33(kSh3[3]), c34(kSh3[4]), c35(kSh3[5]),
      c36(kSh3[6]);
  gradient[8] = {T(6) * c30 * xy, T(3) * c30 * (xx - yy), zero};
  gradient[9] = {c31 * yz, c31 * xz, c31 * xy};
  gradient[10] = {T(-2) * c32 * xy, c32 * (T(4) * zz - xx - T(3) * yy), T(8) * c32 * yz};
  gradient[11] = {T(-6) * c33 * xz, T(-6) * c33 * yz, c33 * (T(6) * zz - T(3) * xx - T(3) * yy)};
  gradient[12] = {c34 * (T(4) * zz - T(3) * xx - yy), T(-2) * c34 * xy, T(8) * c34 * xz};
  gradient[13] = {T(2) * c35 * xz, T(-2) * c35 * yz, c35 * (xx - yy)};
  gradient[14] = {T(3) * c36 * (xx - yy), T(-6) * c36 * xy, zero};
}

}  // namespace fluxgs::math
