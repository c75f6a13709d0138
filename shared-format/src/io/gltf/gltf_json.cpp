#include "io/gltf/gltf_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/sanitize.h"
#include "io/gltf/gltf_camera.h"
#include "io/gltf/gltf_filter.h"
#include "io/json_text.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxEntries = 65536;

// The splat data do not depend on materials, so an unlit one may be required; quantized positions
// are read.
constexpr std::array<std::string_view, 4> kKnownRequired{
    kSplatExtension, kCompactExtension, "KHR_mesh_quantization", "KHR_materials_unlit"};

bool is_spz_extension(std::string_view name) {
  return std::ranges::find(kSpzExtensionNames, name) != kSpzExtensionNames.end();
}

// Collects the first thing that is wrong; the checks read as a list.
class Checker {
 public:
  Checker(const json& root, const std::string& name) : root_(root), name_(name) {}

  bool failed() const { return !error_.what.empty(); }
  const Error& error() const { return error_; }

  void bad(std::string field, std::string what) {
    if (!failed()) error_ = {name_, std::move(field), std::move(what)};
  }

  // A list at the top level, with its members required to be objects; absent is empty.
  const json& list(const char* key) {
    const json& found = member(root_, key);
    return objects(found, key);
  }

  const json& objects(const json& found, const std::string& field) {
    static const json kEmpty = json::array();
    if (found.is_null()) return kEmpty;
    if (!found.is_array() || found.size() > kMaxEntries) {
      bad(field, fmt::format("expected a list of at most {} objects", kMaxEntries));
      return kEmpty;
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i].is_object()) bad(fmt::format("{}[{}]", field, i), "expected an object");
    }
    return failed() ? kEmpty : found;
  }

  // A whole number from 0 to `limit`.
  void whole(const json& value, const std::string& field, std::uint64_t limit) {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() <= limit) return;
    bad(field, fmt::format("{}; expected a whole number from 0 to {}", found(value), limit));
  }

  void numbers(const json& value, const std::string& field, std::size_t count) {
    const bool ok = value.is_array() && value.size() == count &&
                    std::ranges::all_of(value, [](const json& v) { return v.is_number(); });
    if (!ok) bad(field, fmt::format("{}; expected {} numbers", found(value), count));
  }

  std::vector<std::string> strings(const char* key) {
    std::vector<std::string> result;
    const json& found = member(root_, key);
    if (found.is_null()) return result;
    if (!found.is_array() || found.size() > kMaxEntries) bad(key, "expected a list of names");
    if (failed()) return result;
    for (const json& entry : found) {
      if (entry.is_string()) {
        result.push_back(sanitized(entry.get_ref<const std::string&>(), 200));
      } else {
        bad(key, "expected names, found " + shown(entry));
      }
    }
    return result;
  }

 private:
  const json& root_;
  const std::string& name_;
  Error error_;
};

constexpr auto kIndexLimit = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
constexpr auto kSizeLimit = std::uint64_t(1)
                            << 53;  // the whole numbers of JSON that all parsers keep

// Copy the named members of each object, which are whole numbers, into a reduced list.
json reduce(Checker& check, const json& objects, const std::string& field,
            std::initializer_list<const char*> indices, std::initializer_list<const char*> sizes) {
  json result = json::array();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    json entry = json::object();
    const auto copy = [&](const char* key, std::uint64_t limit) {
      const json& value = member(objects[i], key);
      if (value.is_null()) return;
      check.whole(value, fmt::format("{}[{}].{}", field, i, key), limit);
      entry[key] = value;
    };
    for (const char* key : indices) copy(key, kIndexLimit);
    for (const char* key : sizes) copy(key, kSizeLimit);
    result.push_back(std::move(entry));
  }
  return result;
}

void check_required(Checker& check) {
  for (const std::string& extension : check.strings("extensionsRequired")) {
    if (std::ranges::find(kKnownRequired, extension) != kKnownRequired.end()) continue;
    if (is_spz_extension(extension)) continue;
    check.bad("extensionsRequired",
              fmt::format("{} is needed to read this file and is not supported", shown(extension)));
  }
}

std::vector<GltfBuffer> check_buffers(Checker& check) {
  const json& buffers = check.list("buffers");
  std::vector<GltfBuffer> result;
  for (std::size_t i = 0; i < buffers.size() && !check.failed(); ++i) {
    const std::string field = fmt::format("buffers[{}]", i);
    const json& length = member(buffers[i], "byteLength");
    check.whole(length, field + ".byteLength", kSizeLimit);
    const json& uri = member(buffers[i], "uri");
    if (!uri.is_null() && !uri.is_string()) check.bad(field + ".uri", "expected text");
    if (check.failed()) break;
    GltfBuffer& buffer = result.emplace_back();
    buffer.bytes = length.get<std::size_t>();
    if (uri.is_string()) buffer.uri = uri.get<std::string>();
  }
  return result;
}

bool is_vector(const json& value) {
  return value.is_array() && value.size() == 3 &&
         std::ranges::all_of(value, [](const json& v) { return v.is_number(); });
}

// Elements that replace those of an accessor (glTF 2.0, 5.1: accessor.sparse).
json reduce_sparse(Checker& check, const json& sparse, const std::string& field) {
  json result = {{"count", member(sparse, "count")}};
  check.whole(result["count"], field + ".count", kIndexLimit);
  for (const char* part : {"indices", "values"}) {
    const json& from = member(sparse, part);
    const std::string where = fmt::format("{}.{}", field, part);
    json& to = result[part] = json::object();
    to["bufferView"] = member(from, "bufferView");
    check.whole(to["bufferView"], where + ".bufferView", kIndexLimit);
    if (const json& offset = member(from, "byteOffset"); !offset.is_null()) {
      check.whole(offset, where + ".byteOffset", kSizeLimit);
      to["byteOffset"] = offset;
    }
  }
  json& type = result["indices"]["componentType"];
  type = member(member(sparse, "indices"), "componentType");
  check.whole(type, field + ".indices.componentType", kIndexLimit);
  return result;
}

json reduce_accessors(Checker& check) {
  const json& accessors = check.list("accessors");
  json result = reduce(check, accessors, "accessors", {"bufferView", "componentType"},
                       {"byteOffset", "count"});
  for (std::size_t i = 0; i < result.size() && !check.failed(); ++i) {
    const std::string field = fmt::format("accessors[{}]", i);
    const json& type = member(accessors[i], "type");
    const json& normalized = member(accessors[i], "normalized");
    if (!type.is_string()) check.bad(field + ".type", "expected a name such as \"VEC3\"");
    if (!normalized.is_null() && !normalized.is_boolean()) {
      check.bad(field + ".normalized", "expected true or false");
    }
    result[i]["type"] = type;
    if (normalized.is_boolean()) result[i]["normalized"] = normalized;
    // Only a hint for compressed positions, see gltf_spz.h: wrong ones are left out.
    for (const char* key : {"min", "max"}) {
      if (const json& bound = member(accessors[i], key); is_vector(bound)) result[i][key] = bound;
    }
    if (const json& sparse = member(accessors[i], "sparse"); !sparse.is_null())
      result[i]["sparse"] = reduce_sparse(check, sparse, field + ".sparse");
  }
  return result;
}

void check_compact_version(Checker& check, const json& version, const std::string& field) {
  if (version == kCompactVersion || version == kOldestCompactVersion) return;
  check.bad(fmt::format("{}.{}.version", field, kCompactExtension),
            fmt::format("{}; this program reads versions {} and {}", found(version),
                        kOldestCompactVersion, kCompactVersion));
}

// All numbers of the constants, as lists.
constexpr std::pair<const char*, std::size_t> kNormalisation[] = {
    {"center", 3},  {"extent", 1},      {"logScaleMean", 1}, {"logScaleDeviation", 1},
    {"shMean", 12}, {"shDeviation", 12}};
constexpr double kLargestConstant = 1e30;

// "networks" of the compact extension.
json reduce_networks(Checker& check, const json& networks, const std::string& field) {
  if (!networks.is_object()) check.bad(field, "expected an object");
  json kept = json::object();
  for (const char* key : {"psi", "phi"}) {
    const json& view = member(member(networks, key), "bufferView");
    if (member(networks, key).is_null()) continue;
    check.whole(view, fmt::format("{}.{}.bufferView", field, key), kIndexLimit);
    kept[key] = view;
  }
  if (kept.empty()) check.bad(field, "has neither psi nor phi; expected one of them at least");
  const json& constants = member(networks, "normalisation");
  for (const auto& [key, count] : kNormalisation) {
    const std::string name = fmt::format("{}.normalisation.{}", field, key);
    json list = member(constants, key);
    if (list.is_number()) list = json::array({list});
    check.numbers(list, name, count);
    if (check.failed()) return kept;
    for (const json& number : list)
      if (!(std::abs(number.get<double>()) <= kLargestConstant))
        check.bad(name, fmt::format("is beyond {:g}", kLargestConstant));
    kept["normalisation"][key] = list;
  }
  return kept;
}

// What the splats are compressed by, if anything.
void reduce_compression(Checker& check, const json& nested, const std::string& field, json& kept) {
  if (!nested.is_object()) return;
  for (const auto& [key, value] : nested.items()) {
    if (is_spz_extension(key) || key == kCompactExtension) {
      const json& view = member(value, "bufferView");
      check.whole(view, fmt::format("{}.{}.bufferView", field, key), kIndexLimit);
      if (kept.contains(kCompression)) check.bad(field, "its splats are compressed twice");
      kept[kCompression] = key;
      kept[kCompressedView] = view;
      if (key != kCompactExtension) continue;
      kept[kVersion] = member(value, "version");
      check_compact_version(check, kept[kVersion], field);
      if (const json& chunk = member(value, "chunk"); !chunk.is_null()) {
        check.whole(chunk, fmt::format("{}.{}.chunk", field, key), kMaxEntries);
        kept[kChunk] = chunk;
      }
      if (const json& networks = member(value, "networks"); !networks.is_null())
        kept[kNetworks] = reduce_networks(check, networks,
                                          fmt::format("{}.{}.networks", field, kCompactExtension));
    } else if (key.starts_with("KHR_gaussian_splatting_compression")) {
      check.bad(field,
                fmt::format("its splats are compressed by {}, which is not supported", shown(key)));
    }
  }
}

// The extension object of a splat primitive; null for others. Drafts put the compression beside it
// or in its place.
json reduce_splat_extension(Checker& check, const json& extensions, const std::string& field) {
  const json& splats = member(extensions, kSplatExtension);
  json kept = json::object();
  reduce_compression(check, extensions, field, kept);
  if (splats.is_null() && kept.empty()) return nullptr;
  if (!splats.is_null() && !splats.is_object())
    check.bad(field + "." + kSplatExtension, "expected an object");
  reduce_compression(check, member(splats, "extensions"), field, kept);
  for (const char* key : {kKernel, kColorSpace}) {
    const json& value = member(splats, key);
    if (value.is_string()) kept[key] = value;
    if (!value.is_string() && !value.is_null())
      check.bad(fmt::format("{}.{}", field, key), fmt::format("{}; expected a name", found(value)));
  }
  return kept;
}

// The names of the extension for those of its drafts.
json reduce_attributes(Checker& check, const json& attributes, const std::string& field) {
  json result = json::object();
  for (const auto& [key, value] : attributes.items()) {
    check.whole(value, fmt::format("{}.{}", field, shown(key)), kIndexLimit);
    const bool is_draft = key == "_SCALE" || key == "_ROTATION" || key == "_OPACITY" ||
                          key.starts_with("_SH_DEGREE_");
    result[is_draft ? fmt::format("{}:{}", kSplatExtension, key.substr(1)) : key] = value;
  }
  return result;
}

// The attributes and the extension object of a splat primitive; an empty primitive for others, so
// that the indices stay.
json reduce_primitive(Checker& check, const json& primitive, const std::string& field) {
  json result = {{"attributes", json::object()}};
  json extension = reduce_splat_extension(check, member(primitive, "extensions"), field);
  if (extension.is_null()) return result;
  result["extensions"][kSplatExtension] = std::move(extension);
  if (const json& mode = member(primitive, "mode"); !mode.is_null()) {
    check.whole(mode, field + ".mode", kIndexLimit);
    result["mode"] = mode;
  }
  const json& attributes = member(primitive, "attributes");
  if (!attributes.is_object()) {
    check.bad(field + ".attributes", "expected an object");
    return result;
  }
  result["attributes"] = reduce_attributes(check, attributes, field + ".attributes");
  return result;
}

// A primitive takes three bytes of JSON and hundreds in memory: the limit is for all meshes
// together.
json reduce_meshes(Checker& check) {
  const json& meshes = check.list("meshes");
  json result = json::array();
  std::size_t total = 0;
  for (std::size_t i = 0; i < meshes.size() && !check.failed(); ++i) {
    const std::string field = fmt::format("meshes[{}].primitives", i);
    total += member(meshes[i], "primitives").size();
    if (total > kMaxEntries) {
      check.bad(field, fmt::format("more than {} primitives in all meshes", kMaxEntries));
      break;
    }
    json primitives = json::array();
    for (const json& primitive : check.objects(member(meshes[i], "primitives"), field)) {
      primitives.push_back(
          reduce_primitive(check, primitive, fmt::format("{}[{}]", field, primitives.size())));
    }
    result.push_back({{"primitives", std::move(primitives)}});
  }
  return result;
}

// Copy a list of node indices if there is one.
void reduce_indices(Checker& check, const json& from, const char* key, const std::string& field,
                    json& to) {
  const json& list = member(from, key);
  if (list.is_null()) return;
  if (!list.is_array()) return check.bad(field + "." + key, "expected a list of node indices");
  for (const json& index : list) check.whole(index, field + "." + key, kIndexLimit);
  to[key] = list;
}

json reduce_nodes(Checker& check) {
  const json& nodes = check.list("nodes");
  json result = reduce(check, nodes, "nodes", {"mesh"}, {});
  for (std::size_t i = 0; i < result.size() && !check.failed(); ++i) {
    const std::string field = fmt::format("nodes[{}]", i);
    reduce_indices(check, nodes[i], "children", field, result[i]);
    for (const auto& [key, count] : {std::pair("matrix", 16), std::pair("translation", 3),
                                     std::pair("rotation", 4), std::pair("scale", 3)}) {
      const json& value = member(nodes[i], key);
      if (value.is_null()) continue;
      check.numbers(value, field + "." + key, static_cast<std::size_t>(count));
      result[i][key] = value;
    }
  }
  return result;
}

json reduce_scenes(Checker& check) {
  const json& scenes = check.list("scenes");
  json result = json::array();
  for (std::size_t i = 0; i < scenes.size() && !check.failed(); ++i) {
    json entry = json::object();
    reduce_indices(check, scenes[i], "nodes", fmt::format("scenes[{}]", i), entry);
    result.push_back(std::move(entry));
  }
  return result;
}

Expected<GltfJson> check_document(const json& root, const std::string& name) {
  Checker check(root, name);
  const json& version = member(member(root, "asset"), "version");
  if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2.")) {
    check.bad("asset.version", fmt::format("{}; expected \"2.0\"", found(version)));
  }
  check_required(check);
  GltfJson result;
  result.extensions_used = check.strings("extensionsUsed");
  result.buffers = check_buffers(check);
  json reduced = {{"asset", {{"version", "2.0"}}}};
  reduced["bufferViews"] = reduce(check, check.list("bufferViews"), "bufferViews", {"buffer"},
                                  {"byteOffset", "byteLength", "byteStride"});
  reduced["accessors"] = reduce_accessors(check);
  reduced["meshes"] = reduce_meshes(check);
  reduced["nodes"] = reduce_nodes(check);
  reduced["scenes"] = reduce_scenes(check);
  if (const json& scene = member(root, "scene"); !scene.is_null()) {
    check.whole(scene, "scene", kIndexLimit);
    reduced["scene"] = scene;
  }
  if (check.failed()) return std::unexpected(check.error());
  result.reduced = reduced.dump();
  result.start = find_initial_view(root);
  result.filter = find_screen_filter(root, result.warnings);
  return result;
}

}  // namespace

Expected<GltfJson> check_gltf_json(std::string_view text, const std::string& name) {
  const auto root = parse_json_object(text, name, "JSON");
  if (!root) return std::unexpected(root.error());
  try {
    return check_document(*root, name);
  } catch (const json::exception& error) {
    return fail(name, "JSON", sanitized(error.what(), 200));
  }
}

}  // namespace fluxgs::io
