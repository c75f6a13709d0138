// A .gltf: JSON with its buffers inside, or a bundle (file_bundle.h) of it and its files.
#include "fluxgs/io/gltf.h"

#include "file_bundle.h"
#include "folder_of_files.h"
#include "glb_allowance.h"
#include "harness.h"

namespace fluxgs::fuzz {
namespace {

constexpr char kScene[] = "scene.gltf";

}  // namespace

FLUXGS_FUZZ_TARGET(gltf) {
  static FolderOfFiles folder;
  const Files files = files_of(input);
  const auto scene = files.find(kScene);
  is_gltf(input);
  if (scene == files.end())
    return try_reader(input, kGlbAllowance, [](Input bytes) { return read_gltf(bytes, "x"); });
  if (!folder.hold(files)) return Worth::forget;
  return try_reader(input, kGlbAllowance,
                    [&](Input) { return read_gltf_folder(scene->second, folder.path() / kScene); });
}

}  // namespace fluxgs::fuzz
