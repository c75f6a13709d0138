// ZIP archives in memory (PKWARE APPNOTE 6.3), through libzip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"

struct zip;

namespace fluxgs::io {

/// An archive of at most 256 entries that are stored or deflated and not encrypted. Names are those
/// of the archive with slashes for backslashes, which old programs on Windows write.
class ZipArchive {
 public:
  /// Read the directory. `bytes` must outlive the archive; `name` appears in errors.
  static Expected<ZipArchive> open(std::span<const std::byte> bytes, const std::string& name);

  /// Names of the files, without folders and without what macOS adds ("__MACOSX/", "._…",
  /// ".DS_Store").
  std::vector<std::string> files() const;

  /// Inflate one entry and check its CRC. Before anything is allocated its stated size is compared
  /// with `max_bytes` and with 64 KiB + 100 times its compressed size, which must lie inside the
  /// archive; an entry that inflates to more or less than stated is an error.
  Expected<std::vector<std::byte>> read(const std::string& file, std::uint64_t max_bytes) const;

 private:
  struct Discard {
    void operator()(zip* archive) const;
  };
  ZipArchive(zip* archive, std::size_t size, std::string name);

  std::unique_ptr<zip, Discard> archive_;
  std::vector<std::string> names_;  // by index
  std::size_t size_ = 0;
  std::string name_;
};

}  // namespace fluxgs::io
