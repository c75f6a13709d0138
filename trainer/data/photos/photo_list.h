// The photos and videos of a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace fluxgs {

struct Photo {
  std::filesystem::path file;
  std::string name;         ///< path below the folder
  std::uint64_t bytes = 0;  ///< size of the file
};

struct PhotoList {
  std::vector<Photo> photos;  ///< in the order of their names, numbers as numbers
  std::vector<std::filesystem::path> videos;
  std::vector<std::filesystem::path> raw;  ///< raw files of cameras, which cannot be read
};

/// Photos and videos of a folder itself; if it has neither, those of its sub-folders
/// (DCIM/100APPLE). Masks, reduced copies (images_2), and hidden folders are passed over.
PhotoList list_photos(const std::filesystem::path& folder);

/// True for names of folders with what programs make of photos: masks, depths, reduced copies; and
/// for hidden ones.
bool is_made_of_photos(const std::filesystem::path& folder);

/// True for names that end like those of images that can be read, or of videos.
bool is_photo_name(const std::filesystem::path& file);
bool is_video_name(const std::filesystem::path& file);

}  // namespace fluxgs
