// The choice of test images: options, lists of names, and data sets with a choice of their own.
#include <algorithm>

#include "tiny_colmap.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;

/// Ten images a.png … j.png in a COLMAP data set.
class Holdout : public testing::Test {
 protected:
  void SetUp() override {
    write_binary(data_ / "sparse" / "0", ten_images());
    write_views(data_, ten_images());
  }

  static std::string stems(const std::vector<View>& views) {
    std::string text;
    for (const View& view : views) text += fs::path(view.camera.name).stem().string();
    return text;
  }
  /// "train|test"
  std::string split(const LoadOptions& options = {}) {
    const auto data = load_dataset(data_, options);
    if (!data) return data.error().message();
    warnings_ = data->warnings;
    return stems(data->train) + "|" + stems(data->test);
  }
  fs::path list(const std::string& text, const char* name = "list") {
    write_text(folder_.path() / name, text);
    return folder_.path() / name;
  }

  const TempFolder folder_;
  const fs::path data_ = folder_.path() / "data";
  std::vector<std::string> warnings_;
};

TEST_F(Holdout, EveryNth) {
  EXPECT_EQ(split(), "bcdefghj|ai");
  EXPECT_EQ(split({.test_every = 8}), "bcdefghj|ai");
  EXPECT_EQ(split({.test_every = 4}), "bcdfghj|aei");
  EXPECT_EQ(split({.test_every = 0}), "abcdefghij|");
}

TEST_F(Holdout, NamesAreFoundWithOrWithoutFolderAndExtension) {
  const std::string text =
      "# for testing\r\nb.png\r\n\n  c  \nimages/d.png\nC:\\shots\\E.PNG\nf.jpg\n";
  EXPECT_EQ(split({.test_list = list(text)}), "aghij|bcdef");
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Holdout, NamesMayDifferInUnicodeForm) {
  auto model = ten_images();
  model.images[1].name = "\u00e9.png";
  write_binary(data_ / "sparse" / "0", model);
  write_views(data_, model);
  EXPECT_EQ(split({.test_list = list("e\u0301.png\n")}), "acdefghij|\u00e9");
}

TEST_F(Holdout, ListsInTheFolder) {
  for (const char* name : {"test.txt", "test_list.txt", "sparse/0/test.txt"}) {
    write_text(data_ / name, "b.png\nc.png\n");
    EXPECT_EQ(split(), "adefghij|bc") << name;
    EXPECT_EQ(split({.test_every = 0}), "abcdefghij|") << "an option goes first";
    EXPECT_EQ(split({.test_list = list("j")}), "abcdefghi|j");
    fs::remove(data_ / name);
  }
  write_text(data_ / "train.txt", "a\nb\nc\nd\ne\nf\n");
  EXPECT_EQ(split(), "abcdef|ghij") << "all others are for testing";
  write_text(data_ / "test.txt", "g\nh\n");
  EXPECT_EQ(split(), "abcdef|gh");
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("in neither list, left out: i.png, j.png")));
}

TEST_F(Holdout, JsonByNameAndByNumber) {
  for (const char* name : {"train_test_split.json", "train_test_lists.json"}) {
    write_text(data_ / name, R"({"train": ["a.png", "b.png", "c.png"], "test": ["d.png"]})");
    EXPECT_EQ(split(), "abc|d");
    write_text(data_ / name, R"({"train": [0, 1, 2, 99], "test": [4], "val": [5, "f.png", null]})");
    EXPECT_EQ(split(), "abc|ef");
    fs::remove(data_ / name);
  }
  EXPECT_EQ(split({.test_list = list(R"(["i", "j"])", "list.json")}), "abcdefgh|ij");
}

TEST_F(Holdout, ListsThatDoNotFit) {
  write_text(data_ / "test.txt", "1 2 3\nx.png\n");
  EXPECT_EQ(split(), "bcdefghj|ai");
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("test.txt: names none of the images")));
  expect_failure(load_dataset(data_, {.test_list = list("x.png")}), "list", "none of the images");
  expect_failure(load_dataset(data_, {.test_list = folder_.path() / "no"}), "no");
  expect_failure(load_dataset(data_, {.test_list = list("{", "bad.json")}), "bad.json", "JSON");
  expect_failure(load_dataset(data_, {.test_list = list("a\nb\nc\nd\ne\nf\ng\nh\ni\nj")}),
                 "no training images");
}

TEST_F(Holdout, FileNamesInTransforms) {
  fs::remove_all(data_ / "sparse");
  std::string frames;
  for (int i = 0; i < 10; ++i)
    frames += fmt::format(
        "{}{{\"file_path\": \"images/{}.png\", \"transform_matrix\": "
        "[[1,0,0,0],[0,1,0,0],[0,0,1,{}],[0,0,0,1]]}}",
        i == 0 ? "" : ",", static_cast<char>('a' + i), i);
  const auto write = [&](const std::string& lists) {
    write_text(data_ / "transforms.json",
               "{\"fl_x\": 20," + lists + "\"frames\": [" + frames + "]}");
  };
  write("");
  EXPECT_EQ(split(), "bcdefghj|ai");
  write(R"("train_filenames": ["images/a.png", "images/b.png", "images/c.png"],
           "val_filenames": ["images/d.png"], "test_filenames": ["./images/e.png"],)");
  EXPECT_EQ(split(), "abc|de");
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("f.png, g.png, h.png and 2 more")));
  write(R"("test_filenames": ["images/j.png", "images/lost.png"],)");
  EXPECT_EQ(split(), "abcdefghi|j");
  EXPECT_THAT(warnings_,
              ElementsAre(HasSubstr("1 of 2 images for testing are not there: images/lost.png")));
  EXPECT_EQ(split({.test_every = 5}), "bcdeghij|af");
}

}  // namespace
}  // namespace fluxgs
