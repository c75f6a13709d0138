// Photos that do not fit into the memory they may take.
#include "trainer/data/photo_memory.h"

#include <cstdlib>

#include "test_files.h"
#include "trainer/data/dataset.h"
#include "trainer/data/pyramid.h"

namespace fluxgs {
namespace {

using namespace test;

View view_of(int width, int height, int seed) {
  View view;
  view.camera.width = width, view.camera.height = height;
  view.rgb = Image<std::uint8_t>(width, height, 3);
  for (std::size_t i = 0; i < view.rgb.pixels.size(); ++i)
    view.rgb.pixels[i] = static_cast<std::uint8_t>(i * 31 + static_cast<std::size_t>(seed));
  return view;
}

void write_five(const fs::path& folder) {
  std::string frames;
  for (int i = 0; i < 5; ++i) {
    write_image(folder / fmt::format("{}.png", i), pattern(40, 30, 3, i));
    frames += fmt::format(
        "{}{{\"file_path\": \"{}.png\", \"transform_matrix\": "
        "[[1,0,0,{}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}}",
        i > 0 ? "," : "", i, i);
  }
  write_text(folder / "transforms.json", "{\"fl_x\": 20, \"frames\": [" + frames + "]}");
}

TEST(PhotoMemory, WhatDoesNotFitLiesInFiles) {
  PhotoMemory memory(20'000);
  std::vector<View> views, expected;
  for (int i = 0; i < 6; ++i) {
    views.push_back(view_of(64, 48, i));  // 9,216 bytes
    expected.push_back(views.back());
    memory.keep(views.back());
  }
  EXPECT_EQ(memory.in_files(), 4U * 9216);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(is_in_file(views[i].rgb), i >= 2);
    let_go(views[i]);
    EXPECT_EQ(views[i].rgb.pixels, expected[i].rgb.pixels);
    views[i].rgb.pixels[7] ^= 1;  // written, given back, and still there
    let_go(views[i]);
    EXPECT_NE(views[i].rgb.pixels, expected[i].rgb.pixels);
  }
  const View copy = views.back();
  EXPECT_FALSE(is_in_file(copy.rgb));
  EXPECT_EQ(copy.rgb.pixels, views.back().rgb.pixels);
}

TEST(PhotoMemory, ViewsKeepTheirPlaceWhereListsGrow) {
  PhotoMemory memory(1);
  std::vector<View> views;
  for (int i = 0; i < 40; ++i) {
    View view = view_of(16, 8, i);
    memory.keep(view);
    views.push_back(std::move(view));
  }
  for (const View& view : views) EXPECT_TRUE(is_in_file(view.rgb));
}

TEST(PhotoMemory, HalvesLieWhereTheWholeLies) {
  std::vector<View> views = {view_of(64, 48, 1), view_of(64, 48, 2)};
  const View in_memory = halved(views[1]);
  move_to_files(views[1]);
  const ViewPyramid pyramid(views, 1, 8);
  EXPECT_FALSE(is_in_file(pyramid.at(1)[0].rgb));
  EXPECT_TRUE(is_in_file(pyramid.at(1)[1].rgb));
  EXPECT_EQ(pyramid.at(1)[1].rgb.pixels, in_memory.rgb.pixels);
}

TEST(PhotoMemory, LoadedPhotosAreTheSameWhereverTheyLie) {
  const TempFolder folder;
  write_five(folder.path());
  const auto whole = load_dataset(folder.path(), {.test_every = 0});
  const auto filed = load_dataset(folder.path(), {.test_every = 0, .max_photo_bytes = 1});
  ASSERT_TRUE(whole && filed);
  ASSERT_EQ(filed->train.size(), whole->train.size());
  for (std::size_t i = 0; i < whole->train.size(); ++i) {
    EXPECT_TRUE(is_in_file(filed->train[i].rgb)) << i;
    EXPECT_FALSE(is_in_file(whole->train[i].rgb)) << i;
    EXPECT_EQ(filed->train[i].rgb.pixels, whole->train[i].rgb.pixels) << i;
  }
}

TEST(PhotoMemory, AFolderThatCannotHoldThemIsNamed) {
  const TempFolder folder;
  write_five(folder.path());
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before != nullptr ? before : "";
  ::setenv("TMPDIR", (folder.path() / "missing").c_str(), 1);
  const auto data = load_dataset(folder.path(), {.test_every = 0, .max_photo_bytes = 1});
  if (kept.empty())
    ::unsetenv("TMPDIR");
  else
    ::setenv("TMPDIR", kept.c_str(), 1);
  ASSERT_FALSE(data);
  EXPECT_THAT(data.error().message(), testing::StartsWith("0.0 MB for pixels cannot be had in"));
  EXPECT_THAT(data.error().message(), testing::HasSubstr("missing: No such file"));
  EXPECT_THAT(data.error().message(), testing::HasSubstr("--downscale"));
}

}  // namespace
}  // namespace fluxgs
