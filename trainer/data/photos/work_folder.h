// The folder where work on photos is kept, so that it can go on later.
#pragma once

#include <filesystem>
#include <optional>

#include "fluxgs/error.h"

namespace fluxgs {

/// The folder of all work folders: $XDG_CACHE_HOME/fluxgs, else ~/.cache/fluxgs; nothing where
/// neither is known. It may not be there yet.
std::optional<std::filesystem::path> work_folders();

/// Path of the folder for an input below work_folders(), named after the input and its path. The
/// input itself may lie on a medium that cannot be written. Errors: no such place is known.
Expected<std::filesystem::path> work_folder_of(const std::filesystem::path& input);

/// Holds a work folder for one process at a time.
class WorkFolderLock {
 public:
  /// Makes the folder. Errors: it cannot be made, or another process works there.
  static Expected<WorkFolderLock> take(const std::filesystem::path& folder);
  WorkFolderLock(WorkFolderLock&& other) noexcept;
  WorkFolderLock& operator=(WorkFolderLock&&) = delete;
  WorkFolderLock(const WorkFolderLock&) = delete;
  WorkFolderLock& operator=(const WorkFolderLock&) = delete;
  ~WorkFolderLock();

 private:
  explicit WorkFolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace fluxgs
