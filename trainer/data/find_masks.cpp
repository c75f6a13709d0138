#include "trainer/data/find_masks.h"

#include <algorithm>
#include <map>
#include <string>

#include <fmt/format.h>

#include "trainer/data/name_key.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// The key of a path without its extension.
std::string stem_of(const fs::path& name) {
  return name_key(fs::path(name).replace_extension().generic_string());
}

/// Masks by their names below their folder, without extension; the first one in the order of names
/// where there are several.
using Masks = std::map<std::string, fs::path>;

void list_into(const fs::path& folder, Masks& masks) {
  walk_folder(folder, [&](const fs::directory_entry& entry, int) {
    std::error_code ignored;
    if (!entry.is_regular_file(ignored)) return true;
    const auto [known, is_new] =
        masks.emplace(stem_of(entry.path().lexically_relative(folder)), entry.path());
    if (!is_new) known->second = std::min(known->second, entry.path());
    return true;
  });
}

Masks list_masks(const fs::path& folder) {
  Masks masks;
  std::error_code error;
  for (const fs::path& place : {folder, folder / "images"})
    for (const auto& entry : fs::directory_iterator(place, error)) {
      const std::string name = name_key(entry.path().filename().string());
      std::error_code ignored;
      if ((name == "masks" || name == "mask") && entry.is_directory(ignored))
        list_into(entry.path(), masks);
    }
  return masks;
}

/// The mask of a photo that has this name below its folder; empty if there is none.
fs::path mask_of(const fs::path& name, const Masks& masks) {
  for (const std::string& wanted : {name_key(name.generic_string()), stem_of(name)})
    if (const auto found = masks.find(wanted); found != masks.end()) return found->second;
  return {};
}

/// The first name below one of the folders that has a mask.
fs::path mask_of(const SourceFrame& frame, const fs::path& folder, const Masks& masks) {
  for (const fs::path& base : {folder / "images", folder}) {
    const fs::path name = frame.file.lexically_relative(base);
    if (name.empty() || *name.begin() == "..") continue;
    if (const fs::path found = mask_of(name, masks); !found.empty()) return found;
  }
  return mask_of(fs::path(frame.name), masks);
}

}  // namespace

void find_masks(Source& source, const fs::path& folder) {
  const Masks masks = list_masks(folder);
  if (masks.empty()) return;
  bool any = false;
  for (auto* frames : {&source.frames, &source.test_frames})
    for (SourceFrame& frame : *frames) {
      if (frame.mask.empty()) frame.mask = mask_of(frame, folder, masks);
      any = any || !frame.mask.empty();
    }
  if (!any)
    source.warnings.push_back(
        fmt::format("{}: none of its {} files has the name of a photo, and no mask is used; "
                    "expected photo.jpg.png or photo.png for photo.jpg",
                    masks.begin()->second.parent_path().string(), masks.size()));
}

}  // namespace fluxgs
