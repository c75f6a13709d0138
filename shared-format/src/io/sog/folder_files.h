// The files of a folder, by names from a stranger.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// Reads regular files that lie in a folder or below it. A symbolic link may not lead out of it,
/// and no file is read twice: what is read is bounded by what the folder holds.
class FolderFiles {
 public:
  explicit FolderFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// `file` must be a plain name, see is_plain_name().
  Expected<std::vector<std::byte>> read(const std::string& file, std::uint64_t max_bytes);

  /// Sum of the sizes of all files read so far.
  std::size_t bytes() const { return bytes_; }

 private:
  std::filesystem::path folder_;
  std::set<std::filesystem::path> used_;
  std::size_t bytes_ = 0;
};

}  // namespace fluxgs::io
