#include <algorithm>
#include <span>
#include <system_error>

#include <fmt/format.h>

#include "fluxgs/hash.h"
#include "fluxgs/io/file.h"
#include "tools/fluxgs/sweep_run.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

class Hash {
 public:
  void add(std::span<const std::byte> bytes) { value_ = fnv1a(bytes, value_); }
  void add(const std::string& text) {
    add(std::as_bytes(std::span(text.c_str(), text.size() + 1)));  // with its end, to part names
  }
  std::string text() const { return fmt::format("{:016x}", value_); }

 private:
  std::uint64_t value_ = kFnv1aOffset;
};

Expected<std::vector<fs::path>> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  const auto options = fs::directory_options::follow_directory_symlink;
  for (fs::recursive_directory_iterator entry(folder, options, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry.depth() == 0 && entry->path().filename() == "colmap")
      entry.disable_recursion_pending();
    const bool hidden = entry->path().filename().string().starts_with('.');
    if (hidden && entry->is_directory(ignored)) entry.disable_recursion_pending();
    if (!hidden && entry->is_regular_file(ignored))
      files.push_back(entry->path().lexically_relative(folder));
  }
  if (error) return fail(folder.string(), "", "cannot be read: " + error.message());
  std::ranges::sort(files);
  return files;
}

}  // namespace

Expected<std::string> hash_of_data(const fs::path& folder) {
  const auto files = files_of(folder);
  if (!files) return std::unexpected(files.error());
  Hash hash;
  for (const fs::path& file : *files) {
    const auto bytes = read_file(folder / file);
    if (!bytes) return std::unexpected(bytes.error());
    hash.add(file.generic_string());
    hash.add(fmt::format("{}", bytes->size()));
    hash.add(*bytes);
  }
  return hash.text();
}

Expected<std::string> hash_of_file(const fs::path& file) {
  const auto bytes = read_file(file);
  if (!bytes) return std::unexpected(bytes.error());
  Hash hash;
  hash.add(*bytes);
  return hash.text();
}

}  // namespace fluxgs::cli
