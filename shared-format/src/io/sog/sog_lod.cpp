#include "io/sog/sog_lod.h"

#include <cstdint>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "io/json_text.h"
#include "io/sog/named_files.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

constexpr char kField[] = "lod-meta.json";
constexpr std::size_t kMaxFiles = 65536;
constexpr std::uint64_t kMaxRun = std::uint64_t(1) << 31;

std::optional<std::size_t> whole(const json& value, std::uint64_t limit) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > limit) return std::nullopt;
  return static_cast<std::size_t>(value.get<std::uint64_t>());
}

using Runs = std::map<std::size_t, std::size_t>;  // index of a file → splats of level 0 in it

// Recursion is bounded by the depth that parse_json_object() allows.
Expected<void> collect_runs(const json& node, std::size_t files, const std::string& name,
                            Runs& runs) {
  if (!node.is_object()) return fail(name, kField, "tree: expected nodes that are objects");
  if (const json& run = member(member(node, "lods"), "0"); !run.is_null()) {
    const auto file = whole(member(run, "file"), files - 1);
    const auto count = whole(member(run, "count"), kMaxRun);
    if (!file || !count) {
      return fail(name, kField,
                  fmt::format("tree: lods[\"0\"] is {}; expected a file below {} and a count",
                              shown(run), files));
    }
    runs[*file] += *count;
  }
  const json& children = member(node, "children");
  if (children.is_null()) return {};
  if (!children.is_array()) return fail(name, kField, "tree: expected children in a list");
  for (const json& child : children) {
    if (auto done = collect_runs(child, files, name, runs); !done) return done;
  }
  return {};
}

}  // namespace

Expected<std::vector<SogChunk>> parse_sog_lod(const json& root, const std::string& name) {
  // Scenes of before the format had versions lack the member.
  if (const json& version = member(root, "version"); !version.is_null() && version != 1) {
    return fail(name, kField, fmt::format("version: is {}; expected 1", shown(version)));
  }
  const json& files = member(root, "filenames");
  if (!files.is_array() || files.empty() || files.size() > kMaxFiles) {
    return fail(name, kField, fmt::format("filenames: expected 1 to {} names", kMaxFiles));
  }
  Runs runs;
  if (auto done = collect_runs(member(root, "tree"), files.size(), name, runs); !done) {
    return std::unexpected(done.error());
  }
  std::vector<SogChunk> chunks;
  for (const auto& [index, count] : runs) {
    const json& file = files[index];
    if (!file.is_string() || !is_plain_name(file.get_ref<const std::string&>())) {
      return std::unexpected(name_error(name, fmt::format("{}: filenames[{}]", kField, index),
                                        file.is_string() ? file.get<std::string>() : shown(file)));
    }
    if (count > 0) chunks.push_back({file.get<std::string>(), count});
  }
  if (chunks.empty()) return fail(name, kField, "tree: has no splats of level 0, the finest");
  return chunks;
}

}  // namespace fluxgs::io
