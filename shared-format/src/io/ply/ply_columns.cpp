#include "io/ply/ply_columns.h"

#include <algorithm>

#include <fmt/format.h>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

bool has_ply_property(const PlyElement& element, std::string_view property) {
  return std::ranges::find(element.properties, property, &PlyProperty::name) !=
         element.properties.end();
}

Expected<int> ply_sh_degree(const PlyElement& element, const std::string& name) {
  const auto rest = std::ranges::count_if(
      element.properties, [](const auto& p) { return p.name.starts_with("f_rest_"); });
  for (int degree = 0; degree <= 3; ++degree) {
    if (rest == 3 * sh_rest_count(degree)) return degree;
  }
  return fail(
      name, "element " + element.name,
      fmt::format("has {} properties f_rest_*; expected 0, 9, 24 or 45 (degrees 0 to 3)", rest));
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
