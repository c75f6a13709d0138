#include "io/ply/ply_columns.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

bool has_ply_property(const PlyElement& element, std::string_view property) {
  return std::ranges::find(element.properties, property, &PlyProperty::name) !=
         element.properties.end();
}

Expected<int> ply_sh_degree(const PlyElement& element, int highest, const std::string& name) {
  const auto rest = std::ranges::count_if(
      element.properties, [](const auto& p) { return p.name.starts_with("f_rest_"); });
  std::vector<int> counts;
  for (int degree = 0; degree <= highest; ++degree) {
    counts.push_back(3 * sh_rest_count(degree));
    if (rest == counts.back()) return degree;
  }
  return fail(name, "element " + element.name,
              fmt::format("has {} properties f_rest_*; expected one of {} (degrees 0 to {})", rest,
                          fmt::join(counts, ", "), highest));
}

Expected<std::size_t> find_ply_property(const PlyElement& element, std::string_view property,
                                        std::string_view format, const std::string& name) {
  std::size_t found = element.properties.size();
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    if (element.properties[i].name != property) continue;
    if (found < i) {
      return fail(name, "element " + element.name,
                  fmt::format("property {} appears twice", property));
    }
    found = i;
  }
  if (found < element.properties.size()) return found;
  return fail(
      name, "element " + element.name,
      fmt::format("property {} is missing; expected the properties of a {}", property, format));
}

}  // namespace fluxgs::io
