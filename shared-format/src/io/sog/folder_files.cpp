#include "io/sog/folder_files.h"

#include <algorithm>
#include <system_error>

#include "fluxgs/io/file.h"
#include "io/sog/named_files.h"

namespace fluxgs::io {
namespace {

namespace fs = std::filesystem;

bool lies_in(const fs::path& file, const fs::path& folder) {
  return std::ranges::mismatch(folder, file).in1 == folder.end();
}

}  // namespace

Expected<std::vector<std::byte>> FolderFiles::read(const std::string& file,
                                                   std::uint64_t max_bytes) {
  const fs::path path = folder_ / file;
  if (!is_plain_name(file)) return std::unexpected(name_error(folder_.string(), "name", file));
  std::error_code failure;
  const fs::path root = fs::canonical(folder_.empty() ? "." : folder_, failure);
  const fs::path target = failure ? fs::path() : fs::canonical(path, failure);
  if (failure) return fail(path.string(), "open", failure.message());
  if (!lies_in(target, root)) {
    return fail(path.string(), "open", "is a symbolic link that leads out of the scene's folder");
  }
  if (!used_.insert(target).second) {
    return fail(path.string(), "open", "is named twice; expected a file for each purpose");
  }
  auto bytes = read_file(target, max_bytes);
  if (bytes) bytes_ += bytes->size();
  return bytes;
}

}  // namespace fluxgs::io
