#include "trainer/data/pose_places.h"

#include "trainer/data/colmap_model.h"
#include "trainer/data/transforms_source.h"

namespace fluxgs {

std::vector<PosePlace> pose_places(const std::filesystem::path& folder) {
  using enum PosePlace::Kind;
  std::vector<PosePlace> places;
  const auto add_model = [&](const std::filesystem::path& path) {
    if (is_colmap_model(path)) places.push_back({colmap_model, path});
  };
  const auto add_models = [&](const std::filesystem::path& path) {
    if (has_colmap_models(path)) places.push_back({colmap_models, path});
  };
  const auto sparse = folder / "sparse", nerfstudio = folder / "colmap" / "sparse",
             distorted = folder / "distorted" / "sparse";
  add_model(sparse), add_models(sparse);
  add_model(folder);
  if (has_transforms(folder)) places.push_back({transforms, transforms_file(folder)});
  add_models(folder);
  add_model(nerfstudio), add_models(nerfstudio);
  add_model(distorted), add_models(distorted);
  return places;
}

}  // namespace fluxgs
