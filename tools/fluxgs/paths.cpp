#include "tools/fluxgs/paths.h"

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

}  // namespace fluxgs::cli
