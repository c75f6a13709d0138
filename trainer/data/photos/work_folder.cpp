#include "trainer/data/photos/work_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// FNV-1a (http://www.isthe.com/chongo/tech/comp/fnv), to tell folders of the same name apart.
std::uint64_t hash_of(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

/// Only characters that need no quotes in a shell or in a list of files.
std::string plain_name(const fs::path& path) {
  std::string name = path.filename().string().substr(0, 40);
  std::ranges::replace_if(
      name, [](unsigned char c) { return !std::isalnum(c) && c != '.' && c != '-'; }, '_');
  return name;
}

}  // namespace

std::optional<fs::path> work_folders() {
  const auto absolute = [](const char* name) -> std::optional<fs::path> {
    const char* value = std::getenv(name);
    if (value == nullptr || *value != '/') return std::nullopt;
    return value;
  };
  if (const auto cache = absolute("XDG_CACHE_HOME")) return *cache / "fluxgs";
  if (const auto home = absolute("HOME")) return *home / ".cache" / "fluxgs";
  return std::nullopt;
}

Expected<fs::path> work_folder_of(const fs::path& input) {
  const auto cache = work_folders();
  if (!cache)
    return fail(input.string(), "",
                "no place to work in: neither XDG_CACHE_HOME nor HOME names a folder");
  std::error_code ignored;
  const fs::path absolute = fs::weakly_canonical(fs::absolute(input, ignored), ignored);
  const fs::path place = absolute.has_filename() ? absolute : absolute.parent_path();
  return *cache / fmt::format("{}-{:016x}", plain_name(place), hash_of(place.string()));
}

Expected<WorkFolderLock> WorkFolderLock::take(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    return fail(folder.string(), "",
                fmt::format("cannot be created: {}; XDG_CACHE_HOME can name another place",
                            error.message()));
  const fs::path file = folder / "lock";
  WorkFolderLock lock(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (lock.descriptor_ < 0)
    return fail(file.string(), "", fmt::format("cannot be written: {}", std::strerror(errno)));
  // One that only reads its result is gone in a moment
  for (int tries = 0; tries < 50; ++tries) {
    if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) == 0) return lock;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return fail(folder.string(), "",
              "another fluxgs looks for the poses of these photos; wait for it to end");
}

WorkFolderLock::WorkFolderLock(WorkFolderLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

WorkFolderLock::~WorkFolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace fluxgs
