// A folder for the files of a bundle. Set TMPDIR to a folder in memory to save time and a disk.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "file_bundle.h"
#include "io/sog/named_files.h"
#include "support/temp_folder.h"

namespace fluxgs::fuzz {

class FolderOfFiles {
 public:
  const std::filesystem::path& path() const { return folder_.path(); }

  /// Replaces what is there. The names are as hostile as the contents, and must not reach beyond
  /// the folder from here either. False if there are none, or more than a fuzzer has time for.
  bool hold(const Files& files) {
    constexpr std::size_t kMaxFiles = 64;
    if (files.empty() || files.size() > kMaxFiles) return false;
    for (const auto& entry : std::filesystem::directory_iterator(path()))
      std::filesystem::remove_all(entry.path());
    for (const auto& [name, content] : files)
      if (io::is_plain_name(name)) write(path() / name, content);
    return true;
  }

 private:
  static void write(const std::filesystem::path& file, const Bytes& content) {
    std::error_code ignored;  // one name may be a folder of another
    std::filesystem::create_directories(file.parent_path(), ignored);
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "wb"),
                                                                 std::fclose);
    if (stream && !content.empty()) std::fwrite(content.data(), 1, content.size(), stream.get());
  }

  test::TempFolder folder_;
};

}  // namespace fluxgs::fuzz
