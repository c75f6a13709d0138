// SOG of several files (file_bundle.h), which are put into a folder: with a lod-meta.json a
// streamed scene, otherwise an unbundled one. Set TMPDIR to a folder in memory to save time and a
// disk.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "file_bundle.h"
#include "fluxgs/io/sog.h"
#include "harness.h"
#include "io/sog/named_files.h"
#include "sog_allowance.h"
#include "support/temp_folder.h"

namespace fluxgs::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 64;
constexpr char kMeta[] = "meta.json", kLodMeta[] = "lod-meta.json";

// The names are as hostile as the contents, and must not reach beyond the folder from here either.
void write_files(const fs::path& folder, const Files& files) {
  for (const auto& [name, content] : files) {
    if (!io::is_plain_name(name)) continue;
    std::error_code ignored;  // one name may be a folder of another
    fs::create_directories((folder / name).parent_path(), ignored);
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
        std::fopen((folder / name).c_str(), "wb"), std::fclose);
    if (file && !content.empty()) std::fwrite(content.data(), 1, content.size(), file.get());
  }
}

void clear(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) fs::remove_all(entry.path());
}

}  // namespace

FLUXGS_FUZZ_TARGET(sog_folder) {
  static const test::TempFolder folder;
  const Files files = files_of(input);
  if (files.empty() || files.size() > kMaxFiles) return Worth::forget;
  clear(folder.path());
  write_files(folder.path(), files);
  const auto lod = files.find(kLodMeta), meta = files.find(kMeta);
  const Bytes none;
  return try_reader(input, kSogAllowance, [&](Input) {
    if (lod != files.end()) {
      is_sog_lod(lod->second);
      return read_sog_lod(lod->second, folder / kLodMeta);
    }
    const Bytes& text = meta != files.end() ? meta->second : none;
    is_sog_meta(text);
    return read_sog_folder(text, folder / kMeta);
  });
}

}  // namespace fluxgs::fuzz
