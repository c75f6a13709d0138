#include "io/gltf/gltf_filter.h"

#include <fmt/format.h>

#include "io/gltf/gltf_json.h"
#include "io/json_text.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

constexpr char kFilter[] = "screenFilter", kDilation[] = "dilation", kCompensated[] = "compensated";

ScreenFilter filter_of(const json& object, std::vector<std::string>& warnings) {
  ScreenFilter filter;
  const json& dilation = member(object, kDilation);
  const double value = dilation.is_number() ? dilation.get<double>() : 0;
  // As a float, too: less than its least would be no filter
  if (static_cast<float>(value) > 0 && value <= kMaxDilation)
    filter.dilation = value;
  else
    warnings.push_back(
        fmt::format("its screen filter's dilation {}; taken as {} px², expected 0 to {}",
                    found(dilation), filter.dilation, kMaxDilation));
  const json& compensated = member(object, kCompensated);
  if (compensated.is_boolean())
    filter.compensated = compensated.get<bool>();
  else
    warnings.push_back(fmt::format("its screen filter's \"{}\" {}; taken as false", kCompensated,
                                   found(compensated)));
  return filter;
}

}  // namespace

std::optional<ScreenFilter> find_screen_filter(const json& document,
                                               std::vector<std::string>& warnings) {
  const json* first = nullptr;
  bool differ = false;
  for (const json& mesh : member(document, "meshes"))
    for (const json& primitive : member(mesh, "primitives")) {
      const json& extension = member(member(primitive, "extensions"), kSplatExtension);
      const json& filter = member(member(extension, "extras"), kFilter);
      if (!filter.is_object()) continue;
      if (first == nullptr) first = &filter;
      differ = differ || filter != *first;
    }
  if (first == nullptr) return std::nullopt;
  if (differ)
    warnings.emplace_back(
        "its primitives have different screen filters; the first is taken for all");
  return filter_of(*first, warnings);
}

json screen_filter_extras(const ScreenFilter& filter) {
  if (filter == ScreenFilter{}) return nullptr;
  return {{kFilter, {{kDilation, filter.dilation}, {kCompensated, filter.compensated}}}};
}

}  // namespace fluxgs::io
