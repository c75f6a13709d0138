#include "io/sog/zip_archive.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include <fmt/format.h>
#include <zip.h>

#include "cloud/cloud_memory.h"
#include "io/json_text.h"

namespace fluxgs::io {
namespace {

constexpr std::size_t kMaxEntries = 256, kMaxEnds = 8;
constexpr std::uint64_t kMaxRatio = 100, kRatioSlack = 64 << 10;

// End of central directory record, the locator of its 64-bit sibling, and that (APPNOTE 4.3.14 to
// 4.3.16).
constexpr std::string_view kEndMagic = "PK\x05\x06", kLocator64Magic = "PK\x06\x07",
                           kEnd64Magic = "PK\x06\x06";
constexpr std::size_t kEndBytes = 22, kLocator64Bytes = 20, kEnd64Bytes = 56, kMaxComment = 65535;

struct LibzipError {
  zip_error_t value;
  LibzipError() { zip_error_init(&value); }
  ~LibzipError() { zip_error_fini(&value); }
  LibzipError(const LibzipError&) = delete;
  LibzipError& operator=(const LibzipError&) = delete;
  std::string text() { return zip_error_strerror(&value); }
};

struct CloseEntry {
  void operator()(zip_file_t* entry) const { zip_fclose(entry); }
};

template <class T>
T load(std::string_view text, std::size_t at) {
  T value{};
  std::memcpy(&value, text.data() + at, sizeof value);
  return value;
}

// The entries that the end of a directory claims, on this disk or in all, whichever are more; the
// 64-bit end counts where there is one.
Expected<std::uint64_t> claimed_entries(std::string_view text, std::size_t end,
                                        const std::string& name) {
  const bool has_locator =
      end >= kLocator64Bytes &&
      text.substr(end - kLocator64Bytes, kLocator64Magic.size()) == kLocator64Magic;
  if (!has_locator)
    return std::max(load<std::uint16_t>(text, end + 8), load<std::uint16_t>(text, end + 10));
  const auto at = load<std::uint64_t>(text, end - kLocator64Bytes + 8);
  if (at > text.size() || text.size() - at < kEnd64Bytes ||
      text.substr(static_cast<std::size_t>(at), kEnd64Magic.size()) != kEnd64Magic)
    return fail(name, "ZIP", "the end of its 64-bit directory is not where it is said to be");
  const auto end64 = static_cast<std::size_t>(at);
  return std::max(load<std::uint64_t>(text, end64 + 24), load<std::uint64_t>(text, end64 + 32));
}

// How many entries the directory claims, in whichever of its possible ends libzip will believe:
// libzip itself tries them all, and takes time and memory for any number of entries (more than
// linear time for hostile names).
Expected<void> check_directory(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text = as_text(bytes);
  const std::size_t longest = kEndBytes + kMaxComment + kLocator64Bytes;
  const std::size_t first = text.size() > longest ? text.size() - longest : 0;
  std::size_t ends = 0;
  for (std::size_t at = text.find(kEndMagic, first); at != text.npos;
       at = text.find(kEndMagic, at + 1)) {
    if (text.size() - at < kEndBytes) break;
    if (++ends > kMaxEnds) {
      return fail(name, "ZIP", fmt::format("has more than {} ends of its directory", kMaxEnds));
    }
    const auto count = claimed_entries(text, at, name);
    if (!count) return std::unexpected(count.error());
    if (*count > kMaxEntries)
      return fail(name, "ZIP",
                  fmt::format("has {} entries; expected at most {}", *count, kMaxEntries));
  }
  if (ends == 0) {
    return fail(name, "ZIP", "has no directory at its end: cut off, or no ZIP archive");
  }
  return {};
}

Expected<void> check_entry(const zip_stat_t& entry, std::size_t archive, std::uint64_t max_bytes,
                           const std::string& name, const std::string& file) {
  constexpr zip_uint64_t kWanted =
      ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
  if ((entry.valid & kWanted) != kWanted) return fail(name, file, "its entry is incomplete");
  if (entry.encryption_method != ZIP_EM_NONE) return fail(name, file, "is encrypted");
  if (entry.comp_method != ZIP_CM_STORE && entry.comp_method != ZIP_CM_DEFLATE) {
    return fail(name, file,
                fmt::format("is compressed by method {}; expected 0 (stored) or 8 (deflated)",
                            entry.comp_method));
  }
  if (entry.comp_size > archive) {
    return fail(
        name, file,
        fmt::format("claims {} compressed bytes in an archive of {}", entry.comp_size, archive));
  }
  const std::uint64_t limit = std::min(max_bytes, kRatioSlack + kMaxRatio * entry.comp_size);
  if (entry.size > limit) {
    return fail(name, file,
                fmt::format("claims {} bytes from {} compressed ones; at most {} are accepted",
                            entry.size, entry.comp_size, limit));
  }
  return {};
}

}  // namespace

void ZipArchive::Discard::operator()(zip* archive) const { zip_discard(archive); }

ZipArchive::ZipArchive(zip* archive, std::size_t size, std::string name)
    : archive_(archive), size_(size), name_(std::move(name)) {
  const auto entries = static_cast<zip_uint64_t>(zip_get_num_entries(archive, 0));
  for (zip_uint64_t i = 0; i < entries; ++i) {
    const char* entry = zip_get_name(archive, i, ZIP_FL_ENC_GUESS);
    names_.emplace_back(entry != nullptr ? entry : "");
    std::ranges::replace(names_.back(), '\\', '/');
  }
}

std::vector<std::string> ZipArchive::files() const {
  std::vector<std::string> result;
  for (const std::string& name : names_) {
    const std::string_view base = std::string_view(name).substr(name.rfind('/') + 1);
    const bool of_macos = name.starts_with("__MACOSX/") || name.contains("/__MACOSX/") ||
                          base.starts_with("._") || base == ".DS_Store";
    if (!base.empty() && !of_macos) result.push_back(name);
  }
  return result;
}

Expected<ZipArchive> ZipArchive::open(std::span<const std::byte> bytes, const std::string& name) {
  if (auto checked = check_directory(bytes, name); !checked) {
    return std::unexpected(checked.error());
  }
  LibzipError error;
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error.value);
  if (source == nullptr) return fail(name, "ZIP", error.text());
  zip_t* archive = zip_open_from_source(source, ZIP_RDONLY, &error.value);
  if (archive == nullptr) {
    zip_source_free(source);
    return fail(name, "ZIP", error.text());
  }
  return ZipArchive(archive, bytes.size(), name);
}

Expected<std::vector<std::byte>> ZipArchive::read(const std::string& file,
                                                  std::uint64_t max_bytes) const {
  zip_stat_t entry;
  zip_stat_init(&entry);
  const auto found = std::ranges::find(names_, file);
  const auto index = static_cast<zip_uint64_t>(found - names_.begin());
  if (found == names_.end() || zip_stat_index(archive_.get(), index, 0, &entry) != 0) {
    return fail(name_, file, "is not in the archive");
  }
  if (auto checked = check_entry(entry, size_, max_bytes, name_, file); !checked) {
    return std::unexpected(checked.error());
  }
  const std::unique_ptr<zip_file_t, CloseEntry> stream(zip_fopen_index(archive_.get(), index, 0));
  if (!stream) return fail(name_, file, zip_strerror(archive_.get()));
  auto bytes = allocate_bytes(static_cast<std::size_t>(entry.size), name_);
  if (!bytes) return bytes;
  std::size_t done = 0;
  while (done < bytes->size()) {
    const zip_int64_t got = zip_fread(stream.get(), bytes->data() + done, bytes->size() - done);
    if (got < 0) return fail(name_, file, zip_file_strerror(stream.get()));
    if (got == 0) {
      return fail(name_, file, fmt::format("ended after {} of its {} bytes", done, entry.size));
    }
    done += static_cast<std::size_t>(got);
  }
  // Reading past the end makes libzip compare the CRC.
  std::array<std::byte, 1> more;
  const zip_int64_t got = zip_fread(stream.get(), more.data(), more.size());
  if (got < 0) return fail(name_, file, zip_file_strerror(stream.get()));
  if (got > 0) return fail(name_, file, fmt::format("holds more than its {} bytes", entry.size));
  return bytes;
}

}  // namespace fluxgs::io
