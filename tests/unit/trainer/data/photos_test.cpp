// Photos without poses: what is read, what COLMAP is asked, and what happens when it fails.
#include <algorithm>

#include "fake_program.h"
#include "tiny_colmap.h"
#include "trainer/data/dataset.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/photos/prepare_photos.h"

namespace fluxgs {
namespace {

using namespace test;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

std::vector<std::string> names_of(const PhotoList& list) {
  std::vector<std::string> names;
  for (const Photo& photo : list.photos) names.push_back(photo.name);
  return names;
}

TEST(PhotoList, OrderAndKinds) {
  const TempFolder folder;
  for (const char* name : {"img10.jpg", "img9.JPG", "img01.heic", "b.webp", "x.mp4", "y.DNG",
                           ".hidden.jpg", "notes.txt", "thumbnails/t.jpg"})
    write_text(folder.path() / name, "x");
  const PhotoList list = list_photos(folder.path());
  EXPECT_THAT(names_of(list), ElementsAre("b.webp", "img01.heic", "img9.JPG", "img10.jpg"));
  EXPECT_EQ(list.videos.size(), 1u);
  EXPECT_EQ(list.raw.size(), 1u);
  EXPECT_EQ(list.photos[0].bytes, 1u);
}

TEST(PhotoList, SubFoldersOnlyWhereThereIsNothingElse) {
  const TempFolder folder;
  for (const char* name : {"100CANON/a.jpg", "101CANON/a.jpg", "masks/a.png", "images_2/a.jpg",
                           "101CANON/deep/er/b.jpg"})
    write_text(folder.path() / name, "x");
  EXPECT_THAT(names_of(list_photos(folder.path())),
              ElementsAre("100CANON/a.jpg", "101CANON/a.jpg", "101CANON/deep/er/b.jpg"));
  write_text(folder.path() / "c.jpg", "x");
  EXPECT_THAT(names_of(list_photos(folder.path())), ElementsAre("c.jpg"));
}

TEST(PreparePhotos, NamesOfCopies) {
  EXPECT_EQ(copy_name("IMG_1.jpg"), "IMG_1.jpg");
  EXPECT_EQ(copy_name("100/my photo #1.HEIC"), "100%2Fmy%20photo%20%231.HEIC.jpg");
  EXPECT_NE(copy_name("a/b.jpg"), copy_name("a_b.jpg"));
}

/// Ten photos a.png … j.png of 32x24, and a colmap that finds poses for them.
class Photos : public testing::Test {
 protected:
  void SetUp() override {
    model_.cameras[0].width = 32;
    model_.cameras[0].height = 24;
    write_views(data_, model_);
    for (TinyImage& image : model_.images) image.name = copy_name(image.name);
    write_binary(here() / "models" / "0", model_);
    write_fake_colmap(here());
  }

  fs::path here() const { return folder_.path(); }
  Expected<Dataset> load() {
    return load_dataset(data_, {.test_every = 0,
                                .steps = [this](const std::string& step, const std::string&,
                                                std::size_t, std::size_t) {
                                  if (steps_.empty() || steps_.back() != step)
                                    steps_.push_back(step);
                                }});
  }
  std::vector<std::string> calls(const std::string& command) const {
    auto lines = lines_of_file(here() / "calls");
    std::erase_if(lines, [&](const auto& line) { return !line.starts_with(command); });
    return lines;
  }
  fs::path work() const {
    const fs::path cache = here() / "cache" / "fluxgs";
    return fs::exists(cache) ? fs::directory_iterator(cache)->path() : fs::path();
  }

  const TempFolder folder_;
  const fs::path data_ = folder_.path() / "my photos; $(touch x)";  // no shell may see this
  TinyModel model_ = ten_images();
  std::vector<std::string> steps_;
  const ScopedVariable path_{"PATH", (folder_.path() / "bin").string() + ":/usr/bin:/bin"};
  const ScopedVariable cache_{"XDG_CACHE_HOME", (folder_.path() / "cache").string()};
};

TEST_F(Photos, ColmapIsRunOnceAndItsLargestModelTaken) {
  auto few = model_;
  few.images.resize(2);
  fs::rename(here() / "models" / "0", here() / "models" / "1");
  write_binary(here() / "models" / "0", few);
  const auto loaded = load();
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->kind, "images (COLMAP)");
  ASSERT_EQ(loaded->train.size(), 10u);
  EXPECT_EQ(loaded->train[0].camera.name, "a.png");
  EXPECT_EQ(loaded->train[0].rgb.pixels, pattern(32, 24).pixels) << "the photo, not its copy";
  EXPECT_THAT(loaded->warnings, ElementsAre(HasSubstr("2 groups")));
  EXPECT_THAT(steps_, ElementsAre("reduced copies", "features", "matches", "poses"));
  EXPECT_EQ(lines_of_file(here() / "pairs").size(), 45u) << "all pairs of ten";
  EXPECT_THAT(calls("feature_extractor"),
              ElementsAre(AllOf(HasSubstr("single_camera 1"), HasSubstr("camera_model OPENCV"),
                                HasSubstr("use_gpu 0"))));

  const std::string before = read_all(here() / "calls");
  ASSERT_TRUE(load());
  EXPECT_EQ(read_all(here() / "calls"), before) << "the second time nothing is run";
  fs::remove(here() / "bin" / "colmap");
  EXPECT_TRUE(load()) << "nor needed";
}

TEST_F(Photos, NothingIsWrittenBesideThePhotos) {
  fs::permissions(data_ / "images", fs::perms::owner_read | fs::perms::owner_exec);
  fs::permissions(data_, fs::perms::owner_read | fs::perms::owner_exec);
  ASSERT_TRUE(load());
  fs::permissions(data_, fs::perms::owner_all);
  fs::permissions(data_ / "images", fs::perms::owner_all);
  EXPECT_EQ(std::distance(fs::directory_iterator(data_), fs::directory_iterator()), 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(data_ / "images"), fs::directory_iterator()), 10);
}

TEST_F(Photos, PhotosThatColmapDoesNotRegisterAreNamed) {
  model_.images.resize(6);
  write_binary(here() / "models" / "0", model_);
  const auto loaded = load();
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->train.size(), 6u);
  EXPECT_EQ(loaded->skipped_images, 4u);
  EXPECT_THAT(loaded->warnings, ElementsAre(AllOf(HasSubstr("4 of 10"),
                                                  HasSubstr("g.png, h.png, i.png and 1 more"))));
}

TEST_F(Photos, APhotoThatCannotBeReadIsLeftOut) {
  write_text(data_ / "images" / "c.png", "no image");
  const auto loaded = load();
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->train.size(), 9u);
  EXPECT_THAT(loaded->warnings, Contains(HasSubstr("c.png")));
  EXPECT_THAT(lines_of_file(here() / "features"), Not(Contains("c.png.jpg")));
  for (const char name : std::string("abdefg"))
    write_text(data_ / "images" / fmt::format("{}.png", name), "no image");
  expect_failure(load(), ".png", "not an image");
}

TEST_F(Photos, ShapesAndLensesHaveCamerasOfTheirOwn) {
  for (const char name : std::string("def"))
    write_image(data_ / "images" / fmt::format("{}.png", name), pattern(24, 32, 3, name));
  auto portrait = model_.cameras[0];
  portrait.id = 2;
  std::swap(portrait.width, portrait.height);
  model_.cameras.push_back(portrait);
  for (const std::size_t i : {3, 4, 5}) model_.images[i].camera_id = 2;
  write_binary(here() / "models" / "0", model_);
  const auto loaded = load();
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->train.size(), 10u);
  EXPECT_TRUE(loaded->warnings.empty()) << loaded->warnings[0];
  EXPECT_THAT(calls("feature_extractor"), ElementsAre(HasSubstr("camera_model OPENCV"),
                                                      HasSubstr("camera_model SIMPLE_RADIAL")))
      << "three photos do not hold all numbers of a lens";
  EXPECT_EQ(loaded->train[3].camera.width, 24);
  EXPECT_EQ(lines_of_file(here() / "pairs").size(), 45u) << "both shapes are compared";
}

TEST_F(Photos, AddedPhotosAreNoticedAndOnlyTheyAreExtracted) {
  ASSERT_TRUE(load());
  write_image(data_ / "images" / "k.png", pattern(32, 24, 3, 77));
  model_.images.push_back({.name = "k.png.jpg"});
  write_binary(here() / "models" / "0", model_);
  fs::remove(here() / "features");
  fs::remove(here() / "pairs");
  const auto loaded = load();
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->train.size(), 11u);
  EXPECT_THAT(lines_of_file(here() / "features"), ElementsAre("k.png.jpg"));
  EXPECT_EQ(lines_of_file(here() / "pairs").size(), 10u);
  EXPECT_THAT(calls("feature_extractor").back(), HasSubstr("existing_camera_id 1"));
  EXPECT_EQ(calls("mapper").size(), 2u);

  fs::remove(data_ / "images" / "b.png");
  const auto fewer = load();
  ASSERT_TRUE(fewer) << fewer.error().message();
  EXPECT_EQ(fewer->train.size(), 10u);
  EXPECT_EQ(calls("mapper").size(), 2u) << "a photo that is gone needs no new run";
}

TEST_F(Photos, ChangedPhotosBeginAnew) {
  ASSERT_TRUE(load());
  write_image(data_ / "images" / "b.png", Image<std::uint8_t>(32, 24, 3));
  ASSERT_TRUE(load());
  EXPECT_EQ(lines_of_file(here() / "features").size(), 20u);
  EXPECT_EQ(calls("mapper").size(), 2u);
}

TEST_F(Photos, AnInterruptedRunGoesOn) {
  // Dies as if killed: in the features, in the second lot of pairs, in the mapper
  write_fake_colmap(here(), "[ $command = feature_extractor ] && kill -9 $$");
  expect_failure(load(), "log.txt", "feature_extractor", "signal 9");
  EXPECT_FALSE(fs::exists(work() / "sparse"));
  write_fake_colmap(here(), "[ $command = matches_importer ] && [ -f $here/pairs ] && kill -9 $$");
  expect_failure(load(), "matches_importer", "signal 9");
  EXPECT_THAT(calls("feature_extractor").back(), HasSubstr("camera_model OPENCV"))
      << "the camera was noted, but not made";
  const std::size_t extracted = calls("feature_extractor").size();
  const auto first = lines_of_file(here() / "pairs");
  EXPECT_EQ(first.size(), 20u);
  write_fake_colmap(here(), "[ $command = mapper ] && mkdir -p $out/0 && kill -9 $$");
  expect_failure(load(), "mapper", "signal 9");
  EXPECT_EQ(calls("feature_extractor").size(), extracted);
  auto pairs = lines_of_file(here() / "pairs");
  EXPECT_EQ(pairs.size(), 45u);
  std::ranges::sort(pairs);
  EXPECT_TRUE(std::ranges::unique(pairs).empty()) << "no pair twice";
  write_fake_colmap(here());
  const auto loaded = load();
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->train.size(), 10u);
  EXPECT_EQ(lines_of_file(here() / "pairs").size(), 45u);
}

TEST_F(Photos, FailuresAreExplainedInOneLine) {
  write_fake_colmap(here(), "echo 'ERROR: trouble'; echo; echo Elapsed; exit 7");
  expect_failure(load(), "log.txt", "feature_extractor ended with status 7", "ERROR: trouble");
  EXPECT_THAT(read_all(work() / "log.txt"), HasSubstr("trouble"));
  write_fake_colmap(here(), "[ $command = matches_importer ] && exit 2");
  expect_failure(load(), "matches_importer ended with status 2");
  fs::remove_all(here() / "models");
  fs::remove_all(here() / "cache");
  write_fake_colmap(here());
  expect_failure(load(), "no poses for 10 photos", "overlap");
  fs::remove_all(here() / "cache");
  write_fake_colmap(here(), "", 40);
  expect_failure(load(), "no poses for 10 photos", "40 points", "sharp");
  write_program(here() / "bin" / "colmap", "exec /nowhere/colmap");
  expect_failure(load(), "colmap");
}

TEST_F(Photos, AFullOrMissingCacheFolderIsNamed) {
  write_text(here() / "file", "x");
  const ScopedVariable cache("XDG_CACHE_HOME", (here() / "file").string());
  expect_failure(load(), "file/fluxgs", "XDG_CACHE_HOME");
  const ScopedVariable none("XDG_CACHE_HOME", ""), home("HOME", "");
  expect_failure(load(), "no place to work in");
}

TEST_F(Photos, WithoutColmapTheErrorSaysWhatToInstall) {
  const ScopedVariable path("PATH", (here() / "empty").string());
  expect_failure(load(), "my photos", "apt install colmap");
  EXPECT_FALSE(fs::exists(here() / "cache")) << "nothing is left behind";
}

TEST(PhotosBadInput, WhatIsThereIsNamed) {
  const TempFolder folder;
  const fs::path here = folder.path();
  const ScopedVariable cache("XDG_CACHE_HOME", (here / "cache").string());
  write_image(here / "one" / "a.png", pattern(32, 24));
  expect_failure(load_dataset(here / "one", {}), "a.png", "the only photo");
  for (const char* name : {"raw/a.DNG", "raw/b.dng", "two/a.mp4", "two/b.mov"})
    write_text(here / name, "x");
  expect_failure(load_dataset(here / "raw", {}), "2 raw files like a.DNG", "JPEG");
  expect_failure(load_dataset(here / "two", {}), "2 videos", "two/a.mp4");
}

}  // namespace
}  // namespace fluxgs
