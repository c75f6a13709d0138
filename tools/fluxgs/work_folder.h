// A temporary folder for what other programs read and write.
#pragma once

#include <filesystem>

namespace fluxgs::cli {

/// Made with a name that nobody can guess, and gone with this.
class WorkFolder {
 public:
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  ///< empty: it could not be made

 private:
  std::filesystem::path path_;
};

}  // namespace fluxgs::cli
