// LPIPS of images from formulas and of rendered views, where its networks are installed.
#include "tools/fluxgs/commands/lpips.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "support/temp_folder.h"

namespace fluxgs::cli {
namespace {

using testing::HasSubstr;

/// ((7x + 13y + 29c + more·(xy mod 5)) mod 64) / 63.
PlanarImage pattern(int more, int width = 64, int height = 64) {
  PlanarImage image(width, height, 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const int value = (7 * x + 13 * y + 29 * c + more * ((x * y) % 5)) % 64;
        image.row(c, y)[x] = static_cast<float>(value) / 63;
      }
  return image;
}

double sum(const std::array<double, 5>& parts) {
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

struct Known {
  const char* network;
  LpipsRange range;
  double total;
  std::array<double, 5> layers;
};

// Values of another program that runs the same weights; its sums for the images of the authors'
// example are the authors' (0.722 and 0.138 with AlexNet).
class KnownLpips : public testing::TestWithParam<Known> {};

TEST_P(KnownLpips, OfTwoPatterns) {
  const auto lpips = Lpips::load(GetParam().network, 1);
  if (!lpips) GTEST_SKIP() << lpips.error().message();
  const auto found = lpips->layers(pattern(0), pattern(1), GetParam().range);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_NEAR(sum(*found), GetParam().total, 2e-6);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR((*found)[i], GetParam().layers[i], 1e-6) << i;
  const auto swapped = lpips->layers(pattern(1), pattern(0), GetParam().range);
  EXPECT_EQ(sum(*swapped), sum(*found));
  EXPECT_EQ(sum(*lpips->layers(pattern(1), pattern(1), GetParam().range)), 0);
}

INSTANTIATE_TEST_SUITE_P(
    Lpips, KnownLpips,
    testing::Values(Known{"vgg",
                          LpipsRange::zero_to_one,
                          0.0753831,
                          {0.0193651, 0.0300462, 0.0096277, 0.0123902, 0.0039539}},
                    Known{"vgg",
                          LpipsRange::minus_one_to_one,
                          0.0815911,
                          {0.0203403, 0.0313471, 0.0099171, 0.0151805, 0.0048062}},
                    Known{"alex",
                          LpipsRange::zero_to_one,
                          0.1126412,
                          {0.0174038, 0.0267989, 0.0297536, 0.0266602, 0.0120248}},
                    Known{"alex",
                          LpipsRange::minus_one_to_one,
                          0.1494969,
                          {0.0293499, 0.0361182, 0.0386852, 0.0290917, 0.0162520}}),
    [](const testing::TestParamInfo<Known>& at) {
      return std::string(at.param.network) +
             (at.param.range == LpipsRange::zero_to_one ? "_01" : "_11");
    });

TEST(Lpips, OfViewsAreThoseOfTheirBytes) {
  const auto lpips = Lpips::load("alex", 2);
  if (!lpips) GTEST_SKIP() << lpips.error().message();
  View view;
  view.camera.width = 48;
  view.camera.height = 40;
  view.rgb = Image<std::uint8_t>(48, 40, 3);
  for (int x = 0; x < 48; ++x) view.rgb.at(x, 5)[0] = static_cast<std::uint8_t>(5 * x);
  const auto show = [&](float more) {
    return [&view, more](const Camera&) -> Expected<PlanarImage> {
      PlanarImage image = planes_of(view.rgb);
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < image.height(); ++y)
          for (int x = 0; x < image.width(); ++x)
            image.row(c, y)[x] = image.row(c, y)[x] / 255 + more;
      return image;
    };
  };
  const auto same = lpips_errors({view}, show(0.001F), *lpips);  // is rounded away
  const auto other = lpips_errors({view}, show(0.3F), *lpips);
  ASSERT_TRUE(same && other);
  EXPECT_EQ(same->at(0).zero_to_one, 0);
  EXPECT_EQ(same->at(0).minus_one_to_one, 0);
  EXPECT_GT(other->at(0).zero_to_one, 0.01);
  // A mask takes pixels out of the mean; it does not make them alike
  View half = view;
  half.used = Image<std::uint8_t>(48, 40, 1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 48; ++x) half.used.at(x, y)[0] = x < 24 ? 255 : 0;
  const auto masked = lpips_errors({half}, show(0.3F), *lpips);
  ASSERT_TRUE(masked);
  EXPECT_GT(masked->at(0).zero_to_one, 0.7 * other->at(0).zero_to_one);
}

TEST(Lpips, ImagesTooSmallOrTooLargeAreNamed) {
  const auto lpips = Lpips::load("vgg", 1);
  if (!lpips) GTEST_SKIP() << lpips.error().message();
  const auto small = lpips->check_size("a.jpg", 31, 400),
             large = lpips->check_size("a.jpg", 100'000, 100'000);
  ASSERT_TRUE(!small && !large);
  EXPECT_THAT(small.error().message(),
              AllOf(HasSubstr("a.jpg: 31×400"), HasSubstr("--lpips needs 32")));
  EXPECT_THAT(large.error().message(), AllOf(HasSubstr("a.jpg: "), HasSubstr("--lpips alex")));
  EXPECT_TRUE(lpips->check_size("a.jpg", 64, 64));
  EXPECT_FALSE(lpips->layers(pattern(0), pattern(0, 64, 48), LpipsRange::zero_to_one));
}

TEST(Lpips, ANetworkThatIsMissingOrAlteredIsNotUsed) {
  const test::TempFolder folder;
  ::setenv("FLUXGS_LPIPS", folder.path().c_str(), 1);
  const auto missing = Lpips::load("vgg", 1);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().message(), HasSubstr("tools/deps/lpips"));
  std::ofstream(folder.path() / "alex.onnx") << 'x';
  std::filesystem::resize_file(folder.path() / "alex.onnx", 9'885'750);
  const auto altered = Lpips::load("alex", 1);
  ASSERT_FALSE(altered);
  EXPECT_THAT(altered.error().message(), HasSubstr("is not the network"));
  ::unsetenv("FLUXGS_LPIPS");
  EXPECT_FALSE(Lpips::load("squeeze", 1));
}

}  // namespace
}  // namespace fluxgs::cli
