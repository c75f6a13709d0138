// Finds the files of images by names that may have been written on another machine.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fluxgs {

/// Not thread-safe. Lists the folders once, when a name is not found as it is.
class ImageFinder {
 public:
  /// Names are relative to the first of these folders that has them.
  explicit ImageFinder(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  /// The file of a name: as it is; with backslashes as slashes; the longest tail of a path of
  /// another machine that exists here; in another case; with another extension, if there is one
  /// such file only. Nothing if there is none.
  std::optional<std::filesystem::path> find(const std::string& name);

 private:
  std::optional<std::filesystem::path> find_exactly(const std::string& name) const;
  std::optional<std::filesystem::path> find_listed(const std::string& name);
  void list();

  std::vector<std::filesystem::path> folders_;
  bool listed_ = false;
  // By path below its folder in lower case, and by that without extension; the empty path where
  // there are several
  std::map<std::string, std::filesystem::path> by_name_, by_stem_;
};

}  // namespace fluxgs
