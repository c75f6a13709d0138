// Finds the files of images by names that may have been written on another machine.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fluxgs {

class ImageFinder {
 public:
  /// Looks for all names. They are relative to the first of the folders that has them.
  ///
  /// The file of a name: as it is; with backslashes as slashes; the longest tail of a path of
  /// another machine that exists here; in another case; the only one with that name before its
  /// extension, for a name without; or with the extension that most of the others have. Where fewer
  /// than half of the names are found so, the rest may have any extension; where these are still
  /// too few, lie in any folder below. Each of these wants a single such file.
  ImageFinder(std::vector<std::filesystem::path> folders, const std::vector<std::string>& names);

  /// Nothing for a name without a file, and for one that was not looked for.
  std::optional<std::filesystem::path> find(const std::string& name) const;

 private:
  using Path = std::filesystem::path;
  using Index = std::map<std::string, Path>;  // the empty path where there are several

  std::optional<Path> find_exactly(const std::string& name) const;
  std::optional<Path> find_as_named(const std::string& name);
  void list();

  std::vector<Path> folders_;
  std::map<std::string, Path> found_;
  bool listed_ = false;
  // In lower case: by path below its folder; by that without extension; by its last part
  Index by_name_, by_stem_, by_last_;
};

}  // namespace fluxgs
