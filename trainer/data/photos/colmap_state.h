// Record of COLMAP's work in a folder, so that an interrupted or extended run goes on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs {

struct ColmapState {
  std::vector<std::string> cameras;  ///< PreparedPhoto::camera of COLMAP's numbers 1, 2 …
  std::map<std::string, std::uint64_t> photos;  ///< sizes of the photos' files by name
  std::map<std::string, int> features;          ///< numbers of features by copy
  std::set<std::string> mapped;   ///< names of the photos that the models were made of; empty: none
  std::uint64_t video_bytes = 0;  ///< size of the video that the frames were taken from
  int video_frames = 0;           ///< that were asked for
};

/// An empty state where there is none, or none that can be understood.
ColmapState read_colmap_state(const std::filesystem::path& work);

Expected<void> write_colmap_state(const std::filesystem::path& work, const ColmapState& state);

}  // namespace fluxgs
