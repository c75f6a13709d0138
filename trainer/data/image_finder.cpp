#include "trainer/data/image_finder.h"

#include <algorithm>

#include "trainer/data/file_bytes.h"
#include "trainer/data/lower_case.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

std::string without_extension(const std::string& name) {
  return fs::path(name).replace_extension().generic_string();
}

/// Calls `use` with the name and then with its tails, longest first, until one is found.
template <class Use>
std::optional<fs::path> first_tail(std::string name, const Use& use) {
  for (;;) {
    if (auto found = use(name)) return found;
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos) return std::nullopt;
    name.erase(0, slash + 1);
  }
}

void add(std::map<std::string, fs::path>& index, const std::string& key, const fs::path& file) {
  const auto [at, is_new] = index.emplace(key, file);
  if (!is_new && at->second != file) at->second.clear();
}

std::optional<fs::path> get(const std::map<std::string, fs::path>& index, const std::string& key) {
  const auto at = index.find(key);
  if (at == index.end() || at->second.empty()) return std::nullopt;
  return at->second;
}

}  // namespace

std::optional<fs::path> ImageFinder::find_exactly(const std::string& name) const {
  for (const fs::path& folder : folders_) {
    // operator/ would let an absolute name take the folder's place
    fs::path candidate = (folder / fs::path(name).relative_path()).lexically_normal();
    if (is_file(candidate)) return candidate;
  }
  return std::nullopt;
}

void ImageFinder::list() {
  listed_ = true;
  for (const fs::path& folder : folders_)
    walk_folder(folder, [&](const fs::directory_entry& entry, int) {
      std::error_code ignored;
      if (!entry.is_regular_file(ignored)) return true;
      const std::string name = lower_case(entry.path().lexically_relative(folder).generic_string());
      add(by_name_, name, entry.path());
      add(by_stem_, without_extension(name), entry.path());
      return true;
    });
}

std::optional<fs::path> ImageFinder::find_listed(const std::string& name) {
  if (!listed_) list();
  const std::string wanted = lower_case(name);
  if (auto found = first_tail(wanted, [&](const std::string& n) { return get(by_name_, n); }))
    return found;
  return first_tail(wanted, [&](const std::string& n) {
    auto found = get(by_stem_, without_extension(n));
    return found ? found : get(by_stem_, n);  // a name that never had an extension
  });
}

std::optional<fs::path> ImageFinder::find(const std::string& name) {
  if (name.empty() || name.find('\0') != std::string::npos) return std::nullopt;
  if (auto found = find_exactly(name)) return found;
  std::string slashed = name;
  std::ranges::replace(slashed, '\\', '/');
  if (auto found = first_tail(slashed, [&](const std::string& n) { return find_exactly(n); }))
    return found;
  return find_listed(slashed);
}

}  // namespace fluxgs
