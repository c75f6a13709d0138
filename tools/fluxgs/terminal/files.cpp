#include "tools/fluxgs/terminal/files.h"

#include <cstdlib>
#include <string>
#include <system_error>

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;

fs::path resolved(const fs::path& path) {
  std::error_code ignored;
  const fs::path absolute = fs::absolute(path, ignored);
  const fs::path canonical = fs::weakly_canonical(absolute, ignored);
  return ignored ? absolute.lexically_normal() : canonical;
}

}  // namespace

bool lies_in(const fs::path& inner, const fs::path& folder) {
  const fs::path way = resolved(inner).lexically_relative(resolved(folder));
  return !way.empty() && *way.begin() != "..";
}

bool same_file(const fs::path& a, const fs::path& b) {
  return !a.empty() && !b.empty() && resolved(a) == resolved(b);
}

Expected<void> check_no_folder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return {};
  return fail(path.string(), "", "is a folder; expected the name of a file to write");
}

Expected<void> check_overwrite(const fs::path& path, bool force) {
  std::error_code ignored;
  if (force || !fs::exists(path, ignored)) return {};
  return fail(path.string(), "", "exists already; --force replaces it, or choose another name");
}

Expected<fs::path> keep_old(const fs::path& path) {
  std::error_code failed;
  if (!fs::exists(path, failed)) return fs::path();
  const fs::path old = resolved(path);  // a link's file, not the link
  constexpr int kMaxKept = 1000;
  for (int i = 1; i <= kMaxKept; ++i) {
    fs::path kept = old.string() + ".~" + std::to_string(i) + "~";
    fs::create_hard_link(old, kept, failed);
    if (!failed) return kept;
    if (failed != std::errc::file_exists) break;
  }
  if (failed == std::errc::permission_denied)
    return fail(path.parent_path().string(), "",
                "nothing can be written there, and the old file cannot be kept: Permission denied");
  return std::unexpected(check_overwrite(path, false).error());
}

TempFolder::TempFolder() {
  std::error_code ignored;
  std::string pattern = (fs::temp_directory_path(ignored) / "fluxgs-XXXXXX").string();
  if (mkdtemp(pattern.data()) != nullptr) path_ = pattern;
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace fluxgs::cli
