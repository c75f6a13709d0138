#include "trainer/data/photo_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "trainer/core/free_memory.h"
#include "trainer/data/dataset.h"
#include "trainer/data/photos/work_folder.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

fs::path folder_for_pixels() {
  if (const char* named = std::getenv("TMPDIR"); named != nullptr && *named != 0) return named;
  std::error_code ignored;
  const auto work = work_folders();
  if (work) fs::create_directories(*work, ignored);
  return work && fs::is_directory(*work, ignored) ? *work : fs::path("/tmp");
}

/// A file that nobody can open by a name, of that many bytes on the disk; −1: errno says why not.
int nameless_file(const fs::path& folder, std::size_t bytes) {
  std::string name = (folder / "pixels-XXXXXX").string();
  const int file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) return file;
  ::unlink(name.c_str());
  const int error = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
  if (error == 0) return file;
  ::close(file);
  errno = error;
  return -1;
}

class FileMemory final : public std::pmr::memory_resource {
  void* do_allocate(std::size_t bytes, std::size_t) override {
    const fs::path folder = folder_for_pixels();
    const int file = nameless_file(folder, bytes);
    void* memory =
        file < 0 ? MAP_FAILED : ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    const int error = errno;
    if (file >= 0) ::close(file);
    if (memory != MAP_FAILED) return memory;
    throw FullDisk(fmt::format("{:.1f} MB for pixels cannot be had in {}: {}",
                               1e-6 * static_cast<double>(bytes), folder.string(),
                               std::generic_category().message(error)));
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t) override {
    ::munmap(memory, bytes);
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override {
    return this == &other;
  }
};

void move_to_file(Image<std::uint8_t>& image) {
  if (image.pixels.empty() || is_in_file(image)) return;
  // Assigned to, an image would keep the memory that it has
  Image<std::uint8_t> moved(image, file_memory());
  std::destroy_at(&image);
  std::construct_at(&image, std::move(moved));
}

void drop_pages(const Image<std::uint8_t>& image) {
  if (image.pixels.empty() || !is_in_file(image)) return;
  auto* pixels = const_cast<std::uint8_t*>(image.pixels.data());
  (void)::madvise(pixels, image.pixels.size(), MADV_DONTNEED);  // they stay in the file
}

std::uint64_t bytes_of(const View& view) {
  return view.rgb.pixels.size() + view.used.pixels.size() + view.alpha.pixels.size();
}

}  // namespace

std::pmr::memory_resource& file_memory() {
  static FileMemory memory;
  return memory;
}

bool is_in_file(const Image<std::uint8_t>& image) {
  return image.pixels.get_allocator().resource() == &file_memory();
}

PhotoMemory::PhotoMemory(std::uint64_t limit)
    : limit_(limit > 0
                 ? limit
                 : available_memory().value_or(std::numeric_limits<std::uint64_t>::max()) / 2) {}

void PhotoMemory::keep(View& view) {
  const std::uint64_t bytes = bytes_of(view);
  if (in_memory_.fetch_add(bytes) + bytes <= limit_) return;
  in_memory_ -= bytes;
  move_to_files(view);
  in_files_ += bytes;
}

void PhotoMemory::tell_full(const std::string& reason) {
  const std::scoped_lock lock(mutex_);
  if (full_.empty()) full_ = reason;
}

void move_to_files(View& view) {
  for (auto* layer : {&view.rgb, &view.used, &view.alpha}) move_to_file(*layer);
  let_go(view);
}

void let_go(const View& view) {
  for (const auto* layer : {&view.rgb, &view.used, &view.alpha}) drop_pages(*layer);
}

}  // namespace fluxgs
