#include "io/sog/zip_writer.h"

#include <memory>

#include <zip.h>

#include "cloud/cloud_memory.h"

namespace fluxgs::io {
namespace {

constexpr zip_uint16_t kMidnight = 0, kNewYear1980 = 1 << 5 | 1;  // in the form of MS-DOS

struct FreeSource {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, FreeSource>;

struct DiscardArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};

// Adds a file; its bytes must live until the archive is closed.
bool add_file(zip_t* archive, const std::string& file, std::span<const std::byte> bytes) {
  zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
  if (source == nullptr) return false;
  const zip_int64_t added = zip_file_add(archive, file.c_str(), source, ZIP_FL_ENC_UTF_8);
  if (added < 0) {
    zip_source_free(source);
    return false;
  }
  const auto index = static_cast<zip_uint64_t>(added);
  return zip_set_file_compression(archive, index, ZIP_CM_STORE, 0) == 0 &&
         zip_file_set_dostime(archive, index, kMidnight, kNewYear1980, 0) == 0;
}

Expected<std::vector<std::byte>> content_of(zip_source_t* source, const std::string& name) {
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(source, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0 ||
      zip_source_open(source) != 0)
    return fail(name, "ZIP", "the archive could not be finished");
  auto bytes = allocate_bytes(static_cast<std::size_t>(stat.size), name);
  const bool read = bytes && zip_source_read(source, bytes->data(), bytes->size()) ==
                                 static_cast<zip_int64_t>(bytes->size());
  zip_source_close(source);
  if (bytes && !read) return fail(name, "ZIP", "the archive could not be finished");
  return bytes;
}

}  // namespace

Expected<std::vector<std::byte>> write_zip(
    std::span<const std::pair<std::string, std::vector<std::byte>>> files,
    const std::string& name) {
  const Source sink(zip_source_buffer_create(nullptr, 0, 0, nullptr));
  if (!sink) return fail(name, "memory", "out of memory: the archive could not be begun");
  std::unique_ptr<zip_t, DiscardArchive> archive(
      zip_open_from_source(sink.get(), ZIP_CREATE | ZIP_TRUNCATE, nullptr));
  if (!archive) return fail(name, "ZIP", "the archive could not be begun");
  zip_source_keep(sink.get());  // the archive has taken the one of `sink`
  for (const auto& [file, bytes] : files)
    if (!add_file(archive.get(), file, bytes)) return fail(name, file, zip_strerror(archive.get()));
  if (zip_close(archive.get()) != 0) return fail(name, "ZIP", zip_strerror(archive.get()));
  archive.release();
  return content_of(sink.get(), name);
}

}  // namespace fluxgs::io
