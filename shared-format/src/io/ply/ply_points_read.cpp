#include <algorithm>
#include <array>
#include <new>

#include "fluxgs/io/ply_points.h"
#include "io/ply/ply_columns.h"
#include "io/ply/ply_header.h"
#include "io/ply/ply_rows.h"

namespace fluxgs {
namespace {

using namespace io;

constexpr std::array<std::string_view, 3> kPosition{"x", "y", "z"}, kColor{"red", "green", "blue"};

/// Columns of x, y, z and, if all are there, of red, green, blue.
Expected<std::vector<std::size_t>> find_columns(const PlyElement& vertex, const std::string& name) {
  if (vertex.has_lists())
    return fail(name, "element vertex", "holds a list property; expected only scalars");
  std::vector<std::size_t> columns;
  const auto add = [&](std::string_view property) -> Expected<void> {
    const auto found = find_ply_property(vertex, property, "points .ply", name);
    if (!found) return std::unexpected(found.error());
    columns.push_back(*found);
    return {};
  };
  for (const std::string_view property : kPosition)
    if (auto found = add(property); !found) return std::unexpected(found.error());
  if (std::ranges::all_of(kColor,
                          [&](auto property) { return has_ply_property(vertex, property); }))
    for (const std::string_view property : kColor)
      if (auto found = add(property); !found) return std::unexpected(found.error());
  return columns;
}

std::uint8_t byte_of(double value) {
  return static_cast<std::uint8_t>(value > 0 ? std::min(value, 255.0) : 0.0);  // NaN: 0
}

Expected<void> read_vertices(PlyData& data, const PlyElement& vertex,
                             const std::vector<std::size_t>& columns, const std::string& name,
                             PlyPoints& points) {
  if (auto there = data.check_size(vertex); !there) return there;
  const auto count = static_cast<std::size_t>(vertex.count);
  try {
    points.positions.resize(count);
    points.colors.assign(count, glm::u8vec3(255));
  } catch (const std::bad_alloc&) {
    return fail(name, "element vertex", "not enough memory for the points");
  }
  const bool colored = columns.size() > kPosition.size();
  return data.read<double>(vertex, columns, 0, count, [&](std::size_t i, const double* v) {
    points.positions[i] = {v[0], v[1], v[2]};
    if (colored) points.colors[i] = {byte_of(v[3]), byte_of(v[4]), byte_of(v[5])};
  });
}

}  // namespace

Expected<PlyPoints> read_ply_points(std::span<const std::byte> bytes, const std::string& name) {
  const auto header = parse_ply_header(bytes, name);
  if (!header) return std::unexpected(header.error());
  const auto vertex = std::ranges::find(header->elements, "vertex", &PlyElement::name);
  if (vertex == header->elements.end())
    return fail(name, "header", "has no element \"vertex\"; expected one row of it per point");
  const auto columns = find_columns(*vertex, name);
  if (!columns) return std::unexpected(columns.error());
  const MemoryBytes source(bytes);
  PlyData data(source, header->size, header->encoding, name);
  PlyPoints points;
  for (auto element = header->elements.begin(); element != header->elements.end(); ++element) {
    const auto done = element == vertex ? read_vertices(data, *vertex, *columns, name, points)
                                        : data.skip(*element);
    if (!done) return std::unexpected(done.error());
  }
  return points;
}

}  // namespace fluxgs
