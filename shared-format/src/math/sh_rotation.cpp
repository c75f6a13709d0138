#include "fluxgs/math/sh_rotation.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs::math {
namespace {

constexpr std::size_t kBasis = 15;
// A product rule that integrates every polynomial of degree ≤ 6 on the sphere exactly, so all
// products of two basis functions: Gauss–Legendre with 4 nodes along z, 7 equal steps around it.
constexpr std::array<double, 4> kNodes{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                       0.8611363115940526};
constexpr std::array<double, 4> kWeights{0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                         0.3478548451374538};
constexpr int kSteps = 7;

// matrix += weight·a·bᵀ for the basis functions first … first+size−1.
void add_products(std::span<double> matrix, std::size_t first, std::size_t size, double weight,
                  const double* a, const double* b) {
  for (std::size_t row = 0; row < size; ++row) {
    for (std::size_t column = 0; column < size; ++column) {
      matrix[row * size + column] += weight * a[first + row] * b[first + column];
    }
  }
}

void multiply(std::span<const double> matrix, std::size_t size, glm::vec3* values) {
  std::array<glm::dvec3, 7> result{};
  for (std::size_t row = 0; row < size; ++row) {
    for (std::size_t column = 0; column < size; ++column) {
      result[row] += matrix[row * size + column] * glm::dvec3(values[column]);
    }
  }
  for (std::size_t row = 0; row < size; ++row) values[row] = glm::vec3(result[row]);
}

}  // namespace

// The basis is orthonormal, so the matrix entries are the integrals ∫ Yᵢ(d)·Yⱼ(R⁻¹·d) dd.
ShRotation make_sh_rotation(const Mat3<double>& rotation) {
  ShRotation result{};
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    const double z = kNodes[i], radius = std::sqrt(1 - z * z);
    const double weight = kWeights[i] * 2 * std::numbers::pi / kSteps;
    for (int step = 0; step < kSteps; ++step) {
      const double angle = 2 * std::numbers::pi * step / kSteps;
      const Vec3<double> direction{radius * std::cos(angle), radius * std::sin(angle), z};
      std::array<double, kBasis> here{}, turned{};
      sh_basis(3, direction, here.data());
      sh_basis(3, transpose_times(rotation, direction), turned.data());
      add_products(result.degree1, 0, 3, weight, here.data(), turned.data());
      add_products(result.degree2, 3, 5, weight, here.data(), turned.data());
      add_products(result.degree3, 8, 7, weight, here.data(), turned.data());
    }
  }
  return result;
}

void rotate_sh(const ShRotation& rotation, int degree, glm::vec3* coefficients) {
  if (degree >= 1) multiply(rotation.degree1, 3, coefficients);
  if (degree >= 2) multiply(rotation.degree2, 5, coefficients + 3);
  if (degree >= 3) multiply(rotation.degree3, 7, coefficients + 8);
}

}  // namespace fluxgs::math
