// Memory for the pixels of photos: up to a limit ordinary memory, beyond it files that the system
// writes out and reads again as it needs the room.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <mutex>
#include <new>
#include <string>
#include <utility>

#include "fluxgs/image.h"

namespace fluxgs {

struct View;

/// Pages of nameless files in the folder of TMPDIR, or else that of work (work_folder.h). A file's
/// place on the disk is taken when it is allocated: a full disk is a FullDisk then, and no signal
/// later.
std::pmr::memory_resource& file_memory();

/// What file_memory() throws.
struct FullDisk : std::bad_alloc {
  explicit FullDisk(std::string text_) : text(std::move(text_)) {}
  const char* what() const noexcept override { return text.c_str(); }
  std::string text;  ///< which folder, how many bytes, what the system says
};

/// Counts the photos of a capture into ordinary memory; used by many threads at once.
class PhotoMemory {
 public:
  /// `limit`: bytes; 0: half of what the system can give.
  explicit PhotoMemory(std::uint64_t limit);

  /// Leaves the view's pixels where they are, if there is room, or moves them into file_memory(),
  /// which may throw FullDisk.
  void keep(View& view);
  /// Keeps the first of several reasons why not all photos could be kept.
  void tell_full(const std::string& reason);
  const std::string& full() const { return full_; }     ///< the reason, or empty
  std::uint64_t limit() const { return limit_; }        ///< bytes
  std::uint64_t in_files() const { return in_files_; }  ///< bytes

 private:
  std::uint64_t limit_;
  std::mutex mutex_;
  std::string full_;
  std::atomic<std::uint64_t> in_memory_ = 0, in_files_ = 0;
};

/// Moves the pixels into file_memory(), which may throw FullDisk.
void move_to_files(View& view);

/// True if the pixels lie in file_memory().
bool is_in_file(const Image<std::uint8_t>& image);

/// Gives the pages of pixels that lie in files back to the system until they are read again.
void let_go(const View& view);

}  // namespace fluxgs
