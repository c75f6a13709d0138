#include "trainer/data/photos/photo_list.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <system_error>

#include "trainer/data/name_key.h"
#include "trainer/data/walk_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const fs::path& file) { return name_key(file.extension().string()); }

bool is_raw_name(const fs::path& file) {
  constexpr std::string_view kRaw[] = {".dng", ".cr2", ".cr3", ".nef", ".arw",
                                       ".orf", ".rw2", ".raf", ".pef", ".srw"};
  return std::ranges::find(kRaw, lower_extension(file)) != std::end(kRaw);
}

/// Compares names as people do: "img9" comes before "img10".
bool natural_less(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::size_t i = 0, k = 0;
  const auto number = [&](const std::string& text, std::size_t& at) {
    while (at < text.size() && text[at] == '0') ++at;
    const std::size_t begin = at;
    while (at < text.size() && digit(text[at])) ++at;
    return text.substr(begin, at - begin);
  };
  while (i < a.size() && k < b.size()) {
    if (digit(a[i]) && digit(b[k])) {
      const std::string x = number(a, i), y = number(b, k);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      continue;
    }
    if (a[i] != b[k]) return a[i] < b[k];
    ++i, ++k;
  }
  const std::size_t left_a = a.size() - i, left_b = b.size() - k;
  return left_a != left_b ? left_a < left_b : a < b;
}

void add_entry(const fs::directory_entry& entry, const fs::path& root, PhotoList& list) {
  std::error_code error;
  const fs::path& file = entry.path();
  if (file.filename().string().starts_with('.') || !entry.is_regular_file(error)) return;
  if (is_video_name(file)) list.videos.push_back(file);
  if (is_raw_name(file)) list.raw.push_back(file);
  if (!is_photo_name(file)) return;
  const std::uint64_t bytes = entry.file_size(error);
  list.photos.push_back({file, file.lexically_relative(root).generic_string(), error ? 0 : bytes});
}

void add_folder(const fs::path& folder, const fs::path& root, bool with_sub_folders,
                PhotoList& list) {
  constexpr int kDeepest = 4;
  walk_folder(folder, [&](const fs::directory_entry& entry, int depth) {
    add_entry(entry, root, list);
    return with_sub_folders && depth < kDeepest && !is_made_of_photos(entry.path());
  });
}

}  // namespace

bool is_made_of_photos(const fs::path& folder) {
  const std::string name = folder.filename().string();
  constexpr std::string_view kMade[] = {"masks", "mask", "depth", "depths", "sparse", "colmap"};
  return name.starts_with('.') || name.starts_with("images_") ||
         std::ranges::find(kMade, name) != std::end(kMade);
}

bool is_photo_name(const fs::path& file) {
  constexpr std::string_view kPhotos[] = {".jpg", ".jpeg", ".png",  ".webp", ".tif", ".tiff",
                                          ".bmp", ".heic", ".heif", ".hif",  ".avif"};
  return std::ranges::find(kPhotos, lower_extension(file)) != std::end(kPhotos);
}

bool is_video_name(const fs::path& file) {
  constexpr std::string_view kVideos[] = {".mp4", ".mov",  ".m4v", ".avi",  ".mkv", ".webm", ".3gp",
                                          ".mts", ".m2ts", ".mpg", ".mpeg", ".wmv", ".insv", ".ts"};
  return std::ranges::find(kVideos, lower_extension(file)) != std::end(kVideos);
}

PhotoList list_photos(const fs::path& folder) {
  PhotoList list;
  add_folder(folder, folder, false, list);
  if (list.photos.empty() && list.videos.empty() && list.raw.empty())
    add_folder(folder, folder, true, list);
  std::ranges::sort(list.photos, natural_less, &Photo::name);
  std::ranges::sort(list.videos);
  std::ranges::sort(list.raw);
  return list;
}

}  // namespace fluxgs
