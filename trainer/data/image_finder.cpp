#include "trainer/data/image_finder.h"

#include <algorithm>
#include <system_error>

#include "trainer/data/file_bytes.h"
#include "trainer/data/lower_case.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxListed = 1'000'000;  // files of the folders that are looked at

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
  std::size_t count = 0;
  for (const fs::path& folder : folders_) {
    std::error_code error;
    const auto options = fs::directory_options::skip_permission_denied;
    for (fs::recursive_directory_iterator at(folder, options, error), end;
         !error && at != end && count < kMaxListed; at.increment(error), ++count) {
      std::error_code ignored;
      if (!at->is_regular_file(ignored)) continue;
      const std::string name = lower_case(at->path().lexically_relative(folder).generic_string());
      add(by_name_, name, at->path());
      add(by_stem_, without_extension(name), at->path());
    }
  }
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
