// Three values of any scalar type. GLM is used everywhere else; its functions refuse scalar types
// that are packs of SIMD lanes, which the formulas here must accept.
#pragma once

namespace fluxgs::math {

/// A vector.
template <class T>
struct Vec3 {
  T x;  ///< first component
  T y;  ///< second component
  T z;  ///< third component
};

/// A quaternion.
template <class T>
struct Quat {
  T w;  ///< real part
  T x;  ///< of i
  T y;  ///< of j
  T z;  ///< of k
};

/// a + b
template <class T>
Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
/// a − b
template <class T>
Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
/// a·s
template <class T>
Vec3<T> operator*(const Vec3<T>& a, const T& s) {
  return {a.x * s, a.y * s, a.z * s};
}
/// The scalar product.
template <class T>
T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// The vector product.
template <class T>
Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Row-major 3×3 matrix.
template <class T>
struct Mat3 {
  Vec3<T> row0;  ///< first row
  Vec3<T> row1;  ///< second row
  Vec3<T> row2;  ///< third row
};

/// m·v
template <class T>
Vec3<T> operator*(const Mat3<T>& m, const Vec3<T>& v) {
  return {dot(m.row0, v), dot(m.row1, v), dot(m.row2, v)};
}
/// mᵀ·v
template <class T>
Vec3<T> transpose_times(const Mat3<T>& m, const Vec3<T>& v) {
  return m.row0 * v.x + m.row1 * v.y + m.row2 * v.z;
}

}  // namespace fluxgs::math
