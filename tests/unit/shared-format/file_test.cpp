#include "fluxgs/io/file.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "support.h"

namespace fluxgs {
namespace {

using namespace test;

// No more than `bytes` can be written to any file while this lives: a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(ReadFile, ReturnsTheWholeContent) {
  const TemporaryFolder folder;
  const Bytes content = bytes_of(std::string("a\0b\n", 4));
  ASSERT_TRUE(write_file_atomic(folder / "f", content));
  FLUXGS_UNWRAP(read, read_file(folder / "f"));
  EXPECT_EQ(read, content);
  ASSERT_TRUE(write_file_atomic(folder / "empty", {}));
  FLUXGS_UNWRAP(empty, read_file(folder / "empty"));
  EXPECT_TRUE(empty.empty());
}

TEST(ReadFile, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  expect_error(read_file(folder / "missing"), {"missing", "No such file"});
  expect_error(read_file(folder.path()), {folder.path().string(), "folder"});
  expect_error(read_file("/dev/zero"), {"/dev/zero", "not a regular file"});
  ASSERT_TRUE(write_file_atomic(folder / "f", Bytes(100)));
  expect_error(read_file(folder / "f", 99), {"100 bytes", "99"});
  EXPECT_TRUE(read_file(folder / "f", 100));
}

TEST(ReadFile, DoesNotWaitForAPipe) {
  const TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_error(read_file(pipe), {"not a regular file"});
}

TEST(WriteFile, ReplacesAFormerFileAndLeavesNothingElse) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomic(folder / "f", bytes_of("old and long")));
  ASSERT_TRUE(write_file_atomic(folder / "f", bytes_of("new")));
  FLUXGS_UNWRAP(read, read_file(folder / "f"));
  EXPECT_EQ(text_of(read), "new");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteFile, WorksWithARelativeName) {
  const TemporaryFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const auto written = write_file_atomic("plain", bytes_of("x"));
  std::filesystem::current_path(before);
  EXPECT_TRUE(written);
  EXPECT_TRUE(std::filesystem::exists(folder / "plain"));
}

TEST(WriteFile, FollowsASymbolicLink) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomic(folder / "real", bytes_of("old")));
  std::filesystem::create_symlink(folder / "real", folder / "link");
  ASSERT_TRUE(write_file_atomic(folder / "link", bytes_of("new")));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  FLUXGS_UNWRAP(read, read_file(folder / "real"));
  EXPECT_EQ(text_of(read), "new");
}

TEST(WriteFile, FullDiskLeavesTheFormerFileAndNoOther) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file_atomic(folder / "f", bytes_of("precious")));
  {
    const FullDisk disk(64 << 10);
    expect_error(write_file_atomic(folder / "f", Bytes(1 << 20)), {"/f: write: ", "large"});
    expect_error(write_file_atomic(folder / "new", Bytes(1 << 20)), {"/new: write: "});
  }
  EXPECT_EQ(folder.entries(), 1u);
  FLUXGS_UNWRAP(read, read_file(folder / "f"));
  EXPECT_EQ(text_of(read), "precious");
}

TEST(WriteFile, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  expect_error(write_file_atomic(folder / "no/such/f", {}),
               {"no/such/f", "its folder", "no/such does not exist"});
  EXPECT_FALSE(std::filesystem::exists(folder / "no"));
  expect_error(write_file_atomic(folder.path(), {}), {"folder"});
  expect_error(write_file_atomic("/dev/full", {}), {"/dev/full", "not a regular file"});
  expect_error(write_file_atomic("", {}), {"expected the name of a file"});
  expect_error(write_file_atomic(folder / std::string(300, 'n'), bytes_of("x")),
               {"nnn", "name too long"});
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(WriteFile, RefusesAFolderWithoutPermission) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  const TemporaryFolder folder;
  std::filesystem::permissions(
      folder.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  expect_error(write_file_atomic(folder / "f", {}), {"/f", "denied"});
}

TEST(WriteFile, HonoursTheUmask) {
  const TemporaryFolder folder;
  const mode_t before = ::umask(027);
  const auto written = write_file_atomic(folder / "f", {});
  ::umask(before);
  ASSERT_TRUE(written);
  struct stat status{};
  ASSERT_EQ(::stat((folder / "f").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFile, IsInvisibleUntilCommittedAndGoneIfNot) {
  const TemporaryFolder folder;
  {
    FLUXGS_UNWRAP(file, AtomicFile::create(folder / "f"));
    ASSERT_TRUE(file.write(bytes_of("one ")));
    EXPECT_FALSE(std::filesystem::exists(folder / "f"));
    AtomicFile moved = std::move(file);
    ASSERT_TRUE(moved.write(bytes_of("two")));
    ASSERT_TRUE(moved.commit());
  }
  FLUXGS_UNWRAP(read, read_file(folder / "f"));
  EXPECT_EQ(text_of(read), "one two");
  {
    FLUXGS_UNWRAP(abandoned, AtomicFile::create(folder / "g"));
    ASSERT_TRUE(abandoned.write(bytes_of("x")));
    EXPECT_EQ(folder.entries(), 2u);
  }
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(AtomicFile, StaysFailedAfterAFailure) {
  const TemporaryFolder folder;
  FLUXGS_UNWRAP(file, AtomicFile::create(folder / "f"));
  {
    const FullDisk disk(10);
    EXPECT_FALSE(file.write(Bytes(100)));
  }
  EXPECT_EQ(folder.entries(), 0u);
  expect_error(file.write(Bytes(1)), {"/f: write: "});
  expect_error(file.commit(), {"/f: write: "});
  EXPECT_EQ(folder.entries(), 0u);
}

}  // namespace
}  // namespace fluxgs
