#include "tools/fluxgs/read_json.h"

#include "fluxgs/io/file.h"

namespace fluxgs::cli {

Expected<nlohmann::json> read_json(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  const char* text = reinterpret_cast<const char*>(bytes->data());
  auto value = nlohmann::json::parse(text, text + bytes->size(), nullptr, false);
  if (value.is_discarded()) return fail(path.string(), "", "expected JSON");
  return value;
}

}  // namespace fluxgs::cli
