// HEIC and AVIF, where heif-enc of libheif is there to make them.
#include "fake_program.h"
#include "tiny_colmap.h"
#include "trainer/core/process.h"
#include "trainer/data/dataset.h"
#include "trainer/data/photos/prepare_photos.h"

#ifdef __SANITIZE_ADDRESS__
// libheif 1.15 forgets 40 bytes of dav1d for every AVIF file that dav1d cannot decode.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" [[gnu::visibility("default")]] const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libdav1d\n"; }  // NOLINT
#endif

namespace fluxgs {
namespace {

using namespace test;

class Heif : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const auto program = find_program("heif-enc");
    if (!program) GTEST_SKIP() << "no heif-enc";
    encoder_ = *program;
  }
  fs::path here() const { return folder_.path(); }
  /// The image as a file of the format's extension; false where the encoder is missing.
  bool write(const fs::path& file, const Image<std::uint8_t>& image) {
    const fs::path png = here() / "source.png";
    write_image(png, image);
    std::vector<std::string> arguments{"-q", "95", png.string(), "-o", file.string()};
    if (file.extension() == ".avif") arguments.insert(arguments.begin(), "-A");
    fs::create_directories(file.parent_path());
    return run({encoder_, arguments, here() / "log"}) == 0 && fs::exists(file);
  }
  const TempFolder folder_;
  fs::path encoder_;
};

Image<std::uint8_t> smooth(int width, int height, int channels) {
  Image<std::uint8_t> image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(c == 3 ? 128 : 40 + x + y + 30 * c);
  return image;
}

TEST_P(Heif, ImageIsDecoded) {
  for (const int channels : {3, 4}) {
    const fs::path file = here() / (std::string("a") + GetParam());
    const auto image = smooth(64, 48, channels);
    if (!write(file, image)) GTEST_SKIP() << "no encoder for " << GetParam();
    const auto outline = read_image_outline(file);
    ASSERT_TRUE(outline) << outline.error().message();
    EXPECT_EQ(outline->size.width, 64);
    EXPECT_EQ(outline->size.height, 48);
    EXPECT_EQ(outline->exif.orientation, 1);
    const auto decoded = read_image(file);
    ASSERT_TRUE(decoded) << decoded.error().message();
    ASSERT_EQ(decoded->pixels.size(), image.pixels.size());
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      ASSERT_NEAR(decoded->pixels[i], image.pixels[i], 12) << i;
  }
}

TEST_P(Heif, DamageIsAnErrorOfOneLine) {
  const fs::path file = here() / (std::string("a") + GetParam());
  if (!write(file, smooth(64, 48, 3))) GTEST_SKIP() << "no encoder for " << GetParam();
  const std::string whole = read_all(file);
  for (const std::size_t size : {std::size_t{16}, whole.size() / 3, whole.size() - 20}) {
    write_text(file, whole.substr(0, size));
    expect_failure(read_image(file), file.filename().string());
  }
  for (std::size_t at = 8; at < whole.size(); at += 7) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(~damaged[at]);
    write_text(file, damaged);
    if (const auto image = read_image(file); !image) expect_failure(image, "a");
  }
}

TEST_P(Heif, AFolderOfThemIsADataSet) {
  const fs::path data = here() / "photos";
  TinyModel model;
  model.cameras[0].width = 64;
  model.cameras[0].height = 48;
  for (int i = 0; i < 5; ++i) {
    const std::string name = fmt::format("IMG_{}{}", i, GetParam());
    if (!write(data / name, smooth(64, 48, 3))) GTEST_SKIP() << "no encoder for " << GetParam();
    model.images.push_back({.name = copy_name(name)});
  }
  write_binary(here() / "models" / "0", model);
  write_fake_colmap(here());
  const ScopedVariable path("PATH", (here() / "bin").string() + ":/usr/bin:/bin");
  const ScopedVariable cache("XDG_CACHE_HOME", (here() / "cache").string());
  const auto loaded = load_dataset(data, {.test_every = 0});
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->train.size(), 5u);
  EXPECT_EQ(loaded->train[1].camera.name, std::string("IMG_1") + GetParam());
  EXPECT_NEAR(loaded->train[1].rgb.at(5, 5)[0], 50, 12);
}

INSTANTIATE_TEST_SUITE_P(Formats, Heif, testing::Values(".heic", ".avif"),
                         [](const auto& format) { return std::string(format.param).substr(1); });

}  // namespace
}  // namespace fluxgs
