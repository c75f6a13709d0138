#include "codec/positions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "codec/draco_positions.h"
#include "codec/octree.h"
#include "fluxgs/math/finite.h"
#include "fluxgs/morton.h"

namespace fluxgs::codec {
namespace {

constexpr double kMaxSteps = double{1u << kOctreeLevels};

glm::dvec3 lowest(std::span<const glm::vec3> positions) {
  glm::vec3 low(std::numeric_limits<float>::max());
  for (const glm::vec3& p : positions) low = glm::min(low, p);
  return glm::dvec3(low);
}

/// Steps from the origin.
glm::dvec3 steps_to(const glm::vec3& position, const glm::dvec3& origin, double step) {
  return glm::round((glm::dvec3(position) - origin) / step);
}

}  // namespace

std::vector<std::uint32_t> position_order(std::span<const glm::vec3> positions, double step) {
  const glm::dvec3 origin = lowest(positions);
  std::vector<Cell> cells;
  cells.reserve(positions.size());
  for (const glm::vec3& p : positions)  // beyond the range, which encode_positions() refuses
    cells.emplace_back(glm::min(steps_to(p, origin, step), kMaxSteps - 1));
  return morton_order(cells);
}

Expected<void> encode_positions(std::span<const glm::vec3> positions, double step, Bytes& out) {
  const glm::dvec3 origin = lowest(positions);
  std::vector<Cell> cells;
  cells.reserve(positions.size());
  for (const glm::vec3& p : positions) {
    const glm::dvec3 steps = steps_to(p, origin, step);
    const double most = std::max({steps.x, steps.y, steps.z});
    if (!(most < kMaxSteps))
      return fail("", "positions",
                  fmt::format("extend over {:g} steps of {:g}, expected less than {:g}", most, step,
                              kMaxSteps));
    cells.emplace_back(steps);
  }
  for (int c = 0; c < 3; ++c) put(out, origin[c]);
  put(out, step);
  encode_octree(cells, out);
  return {};
}

Expected<void> decode_positions(ByteReader& in, CellCoding coding, std::span<glm::vec3> positions) {
  const auto origin = in.take<std::array<double, 3>>();
  const auto step = in.take<double>();
  if (!origin || !step) return fail("", "positions", "are cut off");
  std::vector<Cell> cells(positions.size());
  if (auto ok = coding == CellCoding::octree ? decode_octree(in, cells) : decode_draco(in, cells);
      !ok)
    return ok;
  const glm::dvec3 from((*origin)[0], (*origin)[1], (*origin)[2]);
  for (std::size_t i = 0; i < positions.size(); ++i)
    positions[i] = glm::vec3(from + *step * glm::dvec3(cells[i]));
  if (math::all_finite({&positions[0].x, 3 * positions.size()})) return {};
  const auto bad = std::ranges::find_if_not(
      positions, [](const glm::vec3& p) { return math::all_finite({&p.x, 3}); });
  return fail("", "positions", fmt::format("splat {} is not finite", bad - positions.begin()));
}

}  // namespace fluxgs::codec
