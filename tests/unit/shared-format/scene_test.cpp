#include "fluxgs/io/scene.h"

#include <algorithm>

#include <fmt/format.h>

#include "fluxgs/io/file.h"
#include "support.h"

namespace fluxgs {
namespace {

using namespace test;

TEST(Scene, FormatIsFoundByContentNotByName) {
  const TemporaryFolder folder;
  const SplatCloud cloud = random_cloud(3, 2);
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;  // read in tests of its own
    const auto path = folder / ("scene" + std::string(format.extension));
    ASSERT_TRUE(write_scene(path, cloud));
    std::filesystem::rename(path, folder / "renamed.bin");
    FLUXGS_UNWRAP(scene, read_scene(folder / "renamed.bin"));
    EXPECT_EQ(scene.format, format.name);
    EXPECT_EQ(scene.bytes, std::filesystem::file_size(folder / "renamed.bin"));
    EXPECT_EQ(scene.cloud.size(), 3u);
    EXPECT_EQ(scene.cloud.sh_degree, std::min(2, format.max_sh_degree));
    EXPECT_EQ(scene.attribute_bits.contains("sh_rest"), scene.cloud.sh_degree > 0);
    for (const char* attribute : {"position", "scale", "rotation", "opacity", "sh_dc"}) {
      const bool with_colour = format.name == "sog" && attribute == std::string("opacity");
      EXPECT_NE(scene.attribute_bits.contains(attribute), with_colour)
          << format.name << ' ' << attribute;
    }
  }
}

TEST(Scene, ExtensionDecidesWhatIsWritten) {
  const TemporaryFolder folder;
  const SplatCloud cloud = random_cloud(1, 0);
  EXPECT_TRUE(write_scene(folder / "A.PLY", cloud));
  for (const char* name : {"a.obj", "a", "a.ply.tmp", ".ply", "aply"}) {
    expect_error(write_scene(folder / name, cloud), {name, "extension", ".ply, .glb"});
  }
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_TRUE(scene_format_for("x.glb"));
  EXPECT_FALSE(scene_format_for("x.png"));
}

TEST(Scene, FormatsThatAreOnlyReadAreNotWritten) {
  const TemporaryFolder folder;
  for (const SceneFormat& format : scene_formats()) {
    const auto path = folder / fmt::format("a{}", format.extension);
    if (format.encode == nullptr) {
      expect_error(write_scene(path, random_cloud(1, 0)),
                   {"extension", format.extension, "read but not written", ".ply, .glb"});
    }
    EXPECT_EQ(scene_format_for(path).has_value(), format.encode != nullptr);
    EXPECT_EQ(
        fmt::format(" {},", writable_extensions()).contains(fmt::format(" {},", format.extension)),
        format.encode != nullptr);
  }
  EXPECT_EQ(folder.entries(), 0u);
  EXPECT_EQ((*scene_format_for("my.own.ply"))->name, "ply");
  EXPECT_EQ((*scene_format_for("Big.Compressed.PLY"))->name, "compressed.ply");
}

TEST(Scene, UnknownContentAndMissingFilesAreExplained) {
  const TemporaryFolder folder;
  expect_error(read_scene(folder / "none.ply"), {"none.ply", "No such file"});
  ASSERT_TRUE(write_file_atomic(folder / "a.ply", bytes_of("PK\x03\x04 something")));
  expect_error(
      read_scene(folder / "a.ply"),
      {"a.ply", "format", "is a ZIP archive without a SOG scene", "3DGS .ply", "glTF binary"});
  ASSERT_TRUE(write_file_atomic(folder / "b.ply", {}));
  expect_error(read_scene(folder / "b.ply"), {"b.ply", "empty"});
  expect_error(read_scene(folder.path()), {"folder"});
  ASSERT_TRUE(write_file_atomic(folder / "transforms.json",
                                bytes_of(R"({"camera_angle_x": 0.7, "frames": []})")));
  expect_error(read_scene(folder / "transforms.json"), {"photos with camera poses"});
}

TEST(Scene, FailedWriteLeavesNothing) {
  const TemporaryFolder folder;
  const SplatCloud cloud = random_cloud(1, 0);
  expect_error(write_scene(folder / "no/a.glb", cloud), {"no/a.glb", "no does not exist"});
  SplatCloud broken = cloud;
  broken.rotations.clear();
  expect_error(write_scene(folder / "a.glb", broken), {"a.glb", "arrays disagree"});
  EXPECT_EQ(folder.entries(), 0u);
}

// Cutting a file anywhere gives an error that names it, whatever the format.
TEST(Scene, CutFilesAreErrorsOfTheirFile) {
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    const auto bytes = format.encode(random_cloud(2, 0), "x", {});
    ASSERT_TRUE(bytes);
    for (std::size_t size = 0; size < bytes->size(); ++size) {
      if (format.name == "splat" && size == 32) continue;  // a whole splat, and nothing tells more
      const Bytes cut(bytes->begin(), bytes->begin() + std::ptrdiff_t(size));
      const auto scene = read_scene(cut, "cut.file");
      ASSERT_FALSE(scene) << format.name << ' ' << size;
      EXPECT_EQ(scene.error().file, "cut.file");
      EXPECT_FALSE(scene.error().what.empty());
    }
  }
}

// The filter that comes back is the one that the table of formats promises.
TEST(Scene, FiltersComeBackFromFormatsThatStoreThem) {
  SplatCloud cloud = random_cloud(20, 0);
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    for (const ScreenFilter filter :
         {ScreenFilter{}, ScreenFilter{0.3, true}, ScreenFilter{0.1, true}}) {
      cloud.filter = filter;
      FLUXGS_UNWRAP(bytes, format.encode(cloud, "x", {}));
      FLUXGS_UNWRAP(scene, read_scene(bytes, "x"));
      EXPECT_EQ(scene.cloud.filter == filter, format.stores(filter)) << format.name;
    }
  }
}

}  // namespace
}  // namespace fluxgs
