#include "fluxgs/io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <exception>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

std::string reason(int error_number) { return std::generic_category().message(error_number); }

const char* kind_of(const struct stat& status) {
  if (S_ISDIR(status.st_mode)) return "is a folder; expected a regular file";
  return "is not a regular file (a device, pipe or socket)";
}

// Closes a descriptor that is only read from, where the result of close() does not matter.
struct ReadDescriptor {
  int value;
  ~ReadDescriptor() {
    if (value >= 0) ::close(value);
  }
};

Expected<std::vector<std::byte>> allocate(const fs::path& path, std::size_t size) {
  try {
    return std::vector<std::byte>(size);
  } catch (const std::exception&) {  // bad_alloc, or length_error beyond what a vector can count
    return fail(path.string(), "memory", fmt::format("out of memory reading {} bytes", size));
  }
}

// read() and write() refuse more than 2^31 bytes at a time on some systems.
constexpr std::size_t kChunk = std::size_t(1) << 30;

}  // namespace

Expected<std::vector<std::byte>> read_file(const fs::path& path, std::uint64_t max_bytes) {
  // O_NONBLOCK: opening a pipe nobody writes to must not hang; regular files ignore the flag.
  const ReadDescriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.value < 0) return fail(path.string(), "open", reason(errno));
  struct stat status{};
  if (::fstat(file.value, &status) != 0) return fail(path.string(), "open", reason(errno));
  if (!S_ISREG(status.st_mode)) return fail(path.string(), "open", kind_of(status));
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > std::min<std::uint64_t>(max_bytes, std::numeric_limits<std::size_t>::max())) {
    return fail(path.string(), "size",
                fmt::format("holds {} bytes; at most {} are accepted here", size, max_bytes));
  }
  auto bytes = allocate(path, static_cast<std::size_t>(size));
  if (!bytes) return bytes;
  for (std::size_t done = 0; done < bytes->size();) {
    const auto got =
        ::read(file.value, bytes->data() + done, std::min(kChunk, bytes->size() - done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(path.string(), "read", reason(errno));
    if (got == 0) {
      return fail(path.string(), "read",
                  fmt::format("ended after {} bytes; its size was {} when opened", done, size));
    }
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

AtomicFile::AtomicFile(fs::path shown, fs::path target, fs::path temporary, int descriptor)
    : shown_(std::move(shown)),
      target_(std::move(target)),
      temporary_(std::move(temporary)),
      descriptor_(descriptor) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : shown_(std::move(other.shown_)),
      target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      descriptor_(std::exchange(other.descriptor_, -1)),
      failure_(std::move(other.failure_)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  if (this == &other) return *this;
  discard();
  shown_ = std::move(other.shown_);
  target_ = std::move(other.target_);
  temporary_ = std::exchange(other.temporary_, {});
  descriptor_ = std::exchange(other.descriptor_, -1);
  failure_ = std::move(other.failure_);
  return *this;
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

Expected<void> AtomicFile::give_up(const char* field, int error_number) {
  discard();
  failure_ = {shown_.string(), field, reason(error_number)};
  return std::unexpected(failure_);
}

Expected<AtomicFile> AtomicFile::create(const fs::path& path) {
  if (path.filename().empty()) return fail(path.string(), "write", "expected the name of a file");
  struct stat status{};
  fs::path target = path;
  if (::stat(path.c_str(), &status) == 0) {
    // Renaming over /dev/null or a folder would do harm or fail late.
    if (!S_ISREG(status.st_mode)) return fail(path.string(), "write", kind_of(status));
    std::error_code ignored;
    const fs::path followed = fs::canonical(path, ignored);
    if (!ignored) target = followed;
  }
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    // A short name of its own: that of the target may already be as long as the system allows.
    fs::path temporary =
        target.parent_path() / fmt::format(".fluxgs-{}-{}.tmp", ::getpid(), counter++);
    const int descriptor =
        ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode_t{0666});
    if (descriptor >= 0)
      return AtomicFile(path, std::move(target), std::move(temporary), descriptor);
    if (std::error_code ignored; errno == ENOENT && !path.parent_path().empty() &&
                                 !fs::is_directory(path.parent_path(), ignored))
      return fail(path.string(), "write",
                  fmt::format("its folder {} does not exist", path.parent_path().string()));
    if (errno != EEXIST) return fail(path.string(), "write", reason(errno));
  }
  return fail(path.string(), "write", "no free name for a temporary file in its folder");
}

Expected<void> AtomicFile::write(std::span<const std::byte> bytes) {
  if (descriptor_ < 0) return std::unexpected(failure_);
  while (!bytes.empty()) {
    const auto put = ::write(descriptor_, bytes.data(), std::min(kChunk, bytes.size()));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return give_up("write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return {};
}

Expected<void> AtomicFile::commit() {
  if (descriptor_ < 0) return std::unexpected(failure_);
  if (::fsync(descriptor_) != 0) return give_up("write", errno);
  // close() reports what a network file system could not store.
  if (::close(std::exchange(descriptor_, -1)) != 0) return give_up("write", errno);
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) return give_up("rename", errno);
  temporary_.clear();
  // The name itself reaches the disk with its folder; some file systems do not offer this, and the
  // content is safe either way.
  const fs::path folder = target_.parent_path();
  const ReadDescriptor opened{
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (opened.value >= 0) ::fsync(opened.value);
  return {};
}

Expected<void> write_file_atomic(const fs::path& path, std::span<const std::byte> bytes) {
  auto file = AtomicFile::create(path);
  if (!file) return std::unexpected(file.error());
  if (auto written = file->write(bytes); !written) return written;
  return file->commit();
}

}  // namespace fluxgs
