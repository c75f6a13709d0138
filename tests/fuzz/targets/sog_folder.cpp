// SOG of several files (file_bundle.h), which are put into a folder: with a lod-meta.json a
// streamed scene, otherwise an unbundled one.
#include "file_bundle.h"
#include "fluxgs/io/sog.h"
#include "folder_of_files.h"
#include "harness.h"
#include "sog_allowance.h"

namespace fluxgs::fuzz {
namespace {

constexpr char kMeta[] = "meta.json", kLodMeta[] = "lod-meta.json";

}  // namespace

FLUXGS_FUZZ_TARGET(sog_folder) {
  static FolderOfFiles folder;
  const Files files = files_of(input);
  if (!folder.hold(files)) return Worth::forget;
  const auto lod = files.find(kLodMeta), meta = files.find(kMeta);
  const Bytes none;
  return try_reader(input, kSogAllowance, [&](Input) {
    if (lod != files.end()) {
      is_sog_lod(lod->second);
      return read_sog_lod(lod->second, folder.path() / kLodMeta);
    }
    const Bytes& text = meta != files.end() ? meta->second : none;
    is_sog_meta(text);
    return read_sog_folder(text, folder.path() / kMeta);
  });
}

}  // namespace fluxgs::fuzz
