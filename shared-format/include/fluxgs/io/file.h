// Whole files in, whole files out: nothing else in the project opens a file to write a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs {

/// The content of a regular file. An error names the path and the reason: missing, no permission,
/// a folder, a device or pipe (never waited for), larger than `max_bytes`, shortened while being
/// read, or out of memory (with the bytes wanted).
Expected<std::vector<std::byte>> read_file(
    const std::filesystem::path& path,
    std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max());

/// A file that appears under its name only when it is complete. Bytes go to a temporary file in the
/// same folder; commit() flushes them to the disk and renames. Without a successful commit() the
/// temporary is removed and a former file of that name is untouched. A symbolic link is followed;
/// devices, pipes and folders are refused. Not thread-safe; different objects are independent.
class AtomicFile {
 public:
  /// Open a temporary file beside `path`. The folder must exist and be writable.
  static Expected<AtomicFile> create(const std::filesystem::path& path);

  /// Leaves `other` without a file.
  AtomicFile(AtomicFile&& other) noexcept;
  /// Gives up the own file and leaves `other` without one.
  AtomicFile& operator=(AtomicFile&& other) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  /// Append bytes. After an error (disk full, quota) the temporary is gone and every further call
  /// fails with the same error.
  Expected<void> write(std::span<const std::byte> bytes);

  /// Flush, rename, close. No further calls may follow.
  Expected<void> commit();

 private:
  AtomicFile(std::filesystem::path shown, std::filesystem::path target,
             std::filesystem::path temporary, int descriptor);
  Expected<void> give_up(const char* field, int error_number);
  void discard();

  std::filesystem::path shown_;      // as the caller named it, for messages
  std::filesystem::path target_;     // with symbolic links followed
  std::filesystem::path temporary_;  // empty once renamed or removed
  int descriptor_ = -1;
  Error failure_;
};

/// All of `bytes` under `path`, or an error and nothing.
Expected<void> write_file_atomic(const std::filesystem::path& path,
                                 std::span<const std::byte> bytes);

}  // namespace fluxgs
