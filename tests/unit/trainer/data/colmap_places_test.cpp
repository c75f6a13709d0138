// The places of COLMAP's models and of their images.
#include "tiny_colmap.h"
#include "trainer/data/dataset.h"
#include "trainer/data/pose_places.h"

namespace fluxgs {
namespace {

using namespace test;

TEST(Colmap, ModelIsFoundInSparseAndInTheFolderItself) {
  for (const char* place : {"sparse/0", "sparse", "."}) {
    const TempFolder folder;
    write_text_model(folder.path() / place, ten_images());
    write_views(folder.path(), ten_images());
    const auto data = load_dataset(folder.path(), {});
    ASSERT_TRUE(data) << place << ": " << data.error().message();
    EXPECT_EQ(data->train.size(), 8U);
  }
}

// 3D Gaussian Splatting's tools keep the photos in input/ and their model in distorted/.
TEST(Colmap, ModelBeforeUndistortionWithItsPhotosInInput) {
  const TempFolder folder;
  write_binary(folder.path() / "distorted" / "sparse" / "0", ten_images());
  write_views(folder.path(), ten_images());
  fs::rename(folder.path() / "images", folder.path() / "input");
  for (const char* given : {".", "distorted/sparse/0"}) {
    const auto data = load_dataset(folder.path() / given, {});
    ASSERT_TRUE(data) << given << ": " << data.error().message();
    EXPECT_EQ(data->train.size(), 8U);
  }
}

TEST(Colmap, APartOfABinaryModelDoesNotHideATextModel) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  const fs::path model = folder.path() / "sparse" / "0";
  remove_file(model / "images.bin");
  expect_failure(load_dataset(folder.path(), {}), "images.bin");
  write_text_model(model, ten_images());
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 8U);
}

TEST(ColmapBadInput, AMissingFileOfAModelIsNamed) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  const fs::path model = folder.path() / "sparse" / "0";
  remove_file(model / "cameras.bin");
  expect_failure(load_dataset(folder.path(), {}), "cameras.bin", "No such file");
  write_text(model / "cameras.txt", "1 PINHOLE 16 12 20 20 8 6\n");
  expect_failure(load_dataset(folder.path(), {}), "cameras.bin", "No such file");
}

TEST(Colmap, ImagesThatWereMadeSmallerAreFound) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  fs::rename(folder.path() / "images", folder.path() / "images_4");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 10u);
}

// Root may read everything.
TEST(ColmapBadInput, FoldersThatMustNotBeReadAreNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "runs as root";
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  for (const char* name : {"sparse/0", "images"}) {
    fs::permissions(folder.path() / name, fs::perms::none);
    expect_failure(load_dataset(folder.path(), {}), name, "cannot be read: Permission denied");
    fs::permissions(folder.path() / name, fs::perms::owner_all);
  }
}

TEST(Colmap, AModelWithoutItsImagesDoesNotHideOtherPoses) {
  const TempFolder folder;
  write_binary(folder.path() / "sparse" / "0", ten_images());
  write_image(folder.path() / "photo.png", pattern(16, 12));
  const std::string frame = R"({"file_path": "photo.png", "transform_matrix":
                             [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})";
  write_text(folder.path() / "transforms.json", R"({"fl_x": 20, "frames": [)" + frame + "]}");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->kind, "transforms.json");
  EXPECT_THAT(data->warnings, testing::Contains(testing::AllOf(
                                  testing::HasSubstr("sparse: none of its images is there"),
                                  testing::HasSubstr("transforms.json is read"))));
  // A file that is named is read although a model lies beside it
  write_views(folder.path(), ten_images());
  fs::rename(folder.path() / "transforms.json", folder.path() / "other.json");
  EXPECT_EQ(load_dataset(folder.path(), {})->kind, "COLMAP");
  EXPECT_EQ(load_dataset(folder.path() / "other.json", {})->kind, "other.json");
}

TEST(Colmap, PhotosGivenAloneAreThoseOfTheModelAboveOnlyIfItHasThem) {
  const TempFolder folder;
  const fs::path data = folder.path() / "garden";
  write_dataset(data, ten_images());
  EXPECT_EQ(load_dataset(data / "images", {})->train.size(), 8U);
  // A reduced copy is read itself
  fs::create_directories(data / "images_2");
  for (const TinyImage& image : ten_images().images)
    write_image(data / "images_2" / image.name, pattern(8, 6));
  const auto reduced = load_dataset(data / "images_2", {});
  ASSERT_TRUE(reduced) << reduced.error().message();
  EXPECT_EQ(reduced->train.at(0).camera.width, 8);
  EXPECT_EQ(reduced->train.at(0).camera.fx, 10);
  // Other photos have no poses here, even where names are the same
  EXPECT_TRUE(pose_places_of_photos(data / "new").empty());
  write_binary(folder.path() / "kitchen", ten_images());
  EXPECT_TRUE(pose_places_of_photos(folder.path() / "hall").empty());
  fs::rename(data / "images", data / "photos");
  fs::remove_all(data / "images_2");
  EXPECT_EQ(load_dataset(data / "photos", {})->train.size(), 8U);
}

TEST(Colmap, DeletedImagesDoNotComeBackFromElsewhere) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  fs::copy(folder.path() / "images", folder.path() / "input");
  remove_file(folder.path() / "images" / "c.png");
  remove_file(folder.path() / "images" / "d.png");
  write_text(folder.path() / "images" / "c.jpg", "a depth map, say");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 8U);
  EXPECT_THAT(data->warnings,
              testing::ElementsAre(testing::HasSubstr("2 of 10 images have no file")));
}

TEST(Colmap, OneFileIsNotTwoImages) {
  const TempFolder folder;
  TinyModel model = ten_images();
  write_views(folder.path(), model);
  model.images[3].name = "left/a.png";
  model.images[0].name = "right/a.png";
  write_binary(folder.path() / "sparse" / "0", model);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 8U);
  EXPECT_THAT(data->warnings, testing::Contains(testing::HasSubstr("right/a.png, left/a.png")));
}

TEST(Colmap, ImagesMayLieDeeperThanTheyAreNamed) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  fs::create_directories(folder.path() / "Photos" / "day 1");
  fs::rename(folder.path() / "images", folder.path() / "Photos" / "day 1" / "x");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 8U);
}

TEST(Colmap, ImagesMayLieInTheFolderItself) {
  const TempFolder folder;
  TinyModel model;
  model.images = {{.name = "sub folder/x y.png"}};  // Names may hold spaces and folders.
  write_text_model(folder.path() / "sparse", model);
  write_image(folder.path() / model.images[0].name, pattern(16, 12));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.at(0).camera.name, "sub folder/x y.png");
}

/// Names in a model that are not those of the files.
void expect_all_found(const fs::path& folder, const TinyModel& model) {
  write_binary(folder / "sparse" / "0", model);
  const auto data = load_dataset(folder, {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), model.images.size());
  EXPECT_TRUE(data->warnings.empty());
}

TEST(Colmap, NamesOfOtherMachinesAreFound) {
  const TempFolder folder;
  auto model = ten_images();
  for (auto& image : model.images) image.name = "left/" + image.name;
  write_views(folder.path(), model);
  model.images[0].name = "left\\a.png";
  model.images[1].name = "C:\\captures\\left\\b.png";
  model.images[2].name = "LEFT/C.PNG";
  model.images[3].name = "left/d.jpg";
  model.images[4].name = "/data/rig/images/left/e.png";
  model.images[5].name = "../left/f.png";
  expect_all_found(folder.path(), model);
}

// Archives made on a Mac compose é of two characters; COLMAP's files come from elsewhere.
TEST(Colmap, NamesMayDifferInUnicodeForm) {
  const TempFolder folder;
  auto model = ten_images();
  model.images[0].name = "caf\u00e9 \ud55c.png";
  model.images[1].name = "e\u0301te\u0301/b.png";
  model.images[2].name = "\u00c5NGSTR\u00d6M.png";
  write_views(folder.path(), model);
  model.images[0].name = "cafe\u0301 \u1112\u1161\u11ab.png";
  model.images[1].name = "\u00e9t\u00e9\\b.png";
  model.images[2].name = "\u00e5ngstr\u00f6m.PNG";
  expect_all_found(folder.path(), model);
}

TEST(Colmap, NamesThatAreNotUtf8AreFound) {
  const TempFolder folder;
  auto model = ten_images();
  model.images[0].name =
      "gr\xfc\xdf"
      "e.png";
  write_views(folder.path(), model);
  model.images[0].name =
      "left/GR\xfc\xdf"
      "E.png";
  expect_all_found(folder.path(), model);
}

TEST(Colmap, TheModelWithMostImagesIsTaken) {
  const TempFolder folder;
  auto model = ten_images();
  write_views(folder.path(), model);
  write_text_model(folder.path() / "sparse" / "1", model);
  model.images.resize(2);
  write_binary(folder.path() / "sparse" / "0", model);
  for (const fs::path& given :
       {folder.path(), folder.path() / "sparse", folder.path() / "images"}) {
    const auto data = load_dataset(given, {});
    ASSERT_TRUE(data) << data.error().message();
    EXPECT_EQ(data->train.size() + data->test.size(), 10u) << given;
    EXPECT_THAT(data->warnings, testing::ElementsAre(testing::HasSubstr("largest of 2 models")));
  }
  EXPECT_EQ(load_dataset(folder.path() / "sparse" / "0", {})->train.size(), 1u);
}

}  // namespace
}  // namespace fluxgs
