// The bytes of a file of which only parts are looked at, so that large ones need not be in memory.
//
// Files are read part by part, not mapped. They lie where others can write: an app opens what other
// apps keep. When a file is cut while it is mapped, the next look behind its new end is SIGBUS,
// which ends the process; a size that was checked before or after does not help. A read that comes
// too late is an error like any other. And only a window of the file is in memory, which mapping
// leaves to the system.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs {

/// Bytes by their offsets. read() may be called from one thread at a time.
class ByteSource {
 public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;

  /// How many there are.
  virtual std::uint64_t size() const = 0;

  /// The bytes at, …, at + count − 1, which must be below size(). They lie in `room` or elsewhere,
  /// and stay until `room` changes. Fails where they are no longer there.
  virtual Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                                    std::vector<std::byte>& room) const = 0;
};

/// Bytes in memory, which must outlive this.
class MemoryBytes final : public ByteSource {
 public:
  /// All of them.
  explicit MemoryBytes(std::span<const std::byte> bytes) : bytes_(bytes) {}
  /// See ByteSource.
  std::uint64_t size() const override { return bytes_.size(); }
  /// See ByteSource; never fails.
  Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                            std::vector<std::byte>&) const override {
    return bytes_.subspan(static_cast<std::size_t>(at), count);
  }

 private:
  std::span<const std::byte> bytes_;
};

/// A part of a regular file. Does not move the place at which others read it.
class FileBytes final : public ByteSource {
 public:
  /// `size` bytes of the file from `begin` on. The descriptor must stay open; `name` appears in
  /// errors.
  FileBytes(int descriptor, std::uint64_t begin, std::uint64_t size, std::string name)
      : descriptor_(descriptor), begin_(begin), size_(size), name_(std::move(name)) {}
  /// See ByteSource.
  std::uint64_t size() const override { return size_; }
  /// See ByteSource.
  Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                            std::vector<std::byte>& room) const override;

 private:
  int descriptor_;
  std::uint64_t begin_, size_;
  std::string name_;
};

}  // namespace fluxgs
