#include "trainer/data/ply_points.h"

#include <fmt/format.h>

#include "fluxgs/io/file.h"
#include "fluxgs/io/ply_points.h"

namespace fluxgs {

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

}  // namespace fluxgs
