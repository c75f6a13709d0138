#include "trainer/data/image_finder.h"

#include <algorithm>

#include "trainer/data/file_bytes.h"
#include "trainer/data/name_key.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

std::string without_extension(const std::string& name) {
  return fs::path(name).replace_extension().generic_string();
}

std::string last_part(const std::string& name) { return fs::path(name).filename().string(); }

std::string with_slashes(std::string name) {
  std::ranges::replace(name, '\\', '/');
  return name;
}

std::string extension_of(const fs::path& file) { return name_key(file.extension().string()); }

/// The extension that most of the files have.
std::string usual_extension(const std::map<std::string, fs::path>& files) {
  std::map<std::string, int> uses;
  for (const auto& [name, file] : files) ++uses[extension_of(file)];
  const auto most = std::ranges::max_element(uses, {}, [](const auto& use) { return use.second; });
  return most == uses.end() ? std::string() : most->first;
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
  if (listed_) return;
  listed_ = true;
  for (const fs::path& folder : folders_)
    walk_folder(folder, [&](const fs::directory_entry& entry, int) {
      std::error_code ignored;
      if (!entry.is_regular_file(ignored)) return true;
      const fs::path below = entry.path().lexically_relative(folder);
      const std::string name = name_key(below.generic_string());
      add(by_name_, name, entry.path());
      add(by_stem_, without_extension(name), entry.path());
      if (std::ranges::none_of(below.parent_path(), is_made_of_photos))
        add(by_last_, last_part(name), entry.path());
      return true;
    });
}

std::optional<fs::path> ImageFinder::find_as_named(const std::string& name) {
  if (name.empty() || name.find('\0') != std::string::npos) return std::nullopt;
  if (auto found = find_exactly(name)) return found;
  const std::string slashed = with_slashes(name);
  if (auto found = first_tail(slashed, [&](const std::string& n) { return find_exactly(n); }))
    return found;
  list();
  const std::string wanted = name_key(name);
  if (auto found = first_tail(wanted, [&](const std::string& n) { return get(by_name_, n); }))
    return found;
  return first_tail(wanted, [&](const std::string& n) {
    auto found = get(by_stem_, n);
    return found ? found : get(by_name_, n + ".png");  // what NeRF-synthetic leaves out
  });
}

ImageFinder::ImageFinder(std::vector<fs::path> folders, const std::vector<std::string>& names)
    : folders_(std::move(folders)) {
  const auto find_rest = [&](const auto& find_one) {
    for (const std::string& name : names)
      if (!found_.contains(name))
        if (auto found = find_one(name)) found_.emplace(name, std::move(*found));
  };
  const auto too_few = [&] { return 2 * found_.size() < names.size(); };
  find_rest([&](const std::string& name) { return find_as_named(name); });
  if (found_.size() < names.size()) list();
  const bool any_extension = too_few();
  const std::string usual = usual_extension(found_);
  find_rest([&](const std::string& name) {
    auto file = first_tail(
        name_key(name), [&](const std::string& n) { return get(by_stem_, without_extension(n)); });
    return file && (any_extension || extension_of(*file) == usual) ? file : std::nullopt;
  });
  if (too_few())
    find_rest([&](const std::string& name) { return get(by_last_, last_part(name_key(name))); });
}

std::optional<fs::path> ImageFinder::find(const std::string& name) const {
  return get(found_, name);
}

}  // namespace fluxgs
