// Comparison of paths that follows symbolic links; files that are there already; temporary folders.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// True for a path that is a folder or lies inside of it; neither needs to exist.
bool lies_in(const std::filesystem::path& inner, const std::filesystem::path& folder);

/// True for two paths of one file, which need not exist; false for an empty path.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// An error where a folder lies in the place of a file that is to be written.
Expected<void> check_no_folder(const std::filesystem::path& path);

/// An error that names --force if something lies under `path` already, unless `force`. For results:
/// asked before long work, so that nobody loses a scene to a habit.
Expected<void> check_overwrite(const std::filesystem::path& path, bool force);

/// A second name of the file that lies under `path`, "NAME.~1~" or the next number that is free, so
/// that it stays when a result takes its name; empty if nothing lies there. What cannot have two
/// names (folders, files on some disks) is an error that names --force.
Expected<std::filesystem::path> keep_old(const std::filesystem::path& path);

/// A folder with an unguessable name that is deleted with this object.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  ///< empty: it could not be made

 private:
  std::filesystem::path path_;
};

}  // namespace fluxgs::cli
