#include "trainer/data/source.h"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <glm/matrix.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/ply_points.h"

namespace fluxgs {

glm::dvec3 camera_position(const SourceFrame& frame) {
  return -(glm::transpose(frame.rotation) * frame.translation);
}

std::vector<glm::dvec3> camera_positions(const Source& source) {
  std::vector<glm::dvec3> positions;
  for (const auto* frames : {&source.frames, &source.test_frames})
    for (const SourceFrame& frame : *frames) positions.push_back(camera_position(frame));
  return positions;
}

bool add_point(Source& source, const glm::dvec3& position, const glm::u8vec3& color) {
  const glm::vec3 p(position);  // A double may be finite and its float not.
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return false;
  source.points.push_back(position);
  source.point_colors.push_back(color);
  return true;
}

Expected<void> add_ply_points(const std::filesystem::path& file, Source& source) {
  const auto bytes = read_file(file);
  if (!bytes) return std::unexpected(bytes.error());
  const auto points = read_ply_points(*bytes, file.string());
  if (!points) return std::unexpected(points.error());
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < points->positions.size(); ++i)
    dropped += !add_point(source, points->positions[i], points->colors[i]);
  if (dropped > 0)
    source.warnings.push_back(
        fmt::format("{}: {} points that are not finite were dropped", file.string(), dropped));
  return {};
}

std::optional<glm::dmat3> nearest_rotation(const glm::dmat3& matrix) {
  Eigen::Matrix3d m;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) m(row, column) = matrix[column][row];
  const double largest = m.cwiseAbs().maxCoeff();
  if (!m.allFinite() || largest <= 0) return std::nullopt;
  m /= largest;  // Before the determinant, which would overflow or vanish.
  if (m.determinant() <= 0) return std::nullopt;
  // The polar factor M(MᵀM)^−½; the eigenvalues of MᵀM are the squares of M's singular values.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> square(m.transpose() * m);
  constexpr double kLargestShear = 1.01;
  const auto& s2 = square.eigenvalues();  // ascending
  if (!(s2[2] <= s2[0] * kLargestShear * kLargestShear)) return std::nullopt;
  const Eigen::Matrix3d r = m * square.operatorInverseSqrt();
  glm::dmat3 rotation;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) rotation[column][row] = r(row, column);
  return rotation;
}

}  // namespace fluxgs
