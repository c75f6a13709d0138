// L1 + SSIM against a direct float64 evaluation and central differences.
#include "trainer/loss/photometric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/sanitized.h"

namespace fluxgs {
namespace {

Image<double> noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Image<double> image(width, height, 3);
  for (double& v : image.pixels) v = uniform(random);
  return image;
}

PlanarImage planar(const Image<double>& image) {
  PlanarImage out(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) out.row(c, y)[x] = static_cast<float>(image.at(x, y)[c]);
  return out;
}

using Mask = Image<std::uint8_t>;

bool counts(const Mask& used, int x, int y) { return used.pixels.empty() || *used.at(x, y) != 0; }

/// Σ SSIM of the windows around pixels that count, straight from the definition (Wang et al. 2004),
/// zero outside the image.
double ssim_sum(const Image<double>& a, const Image<double>& b, const Mask& used) {
  double window[11], total = 0, norm = 0;
  for (int k = 0; k < 11; ++k) norm += window[k] = std::exp(-(k - 5) * (k - 5) / 4.5);
  for (double& w : window) w /= norm;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
        if (!counts(used, x, y)) continue;
        double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        for (int j = std::max(0, y - 5); j <= std::min(a.height - 1, y + 5); ++j)
          for (int i = std::max(0, x - 5); i <= std::min(a.width - 1, x + 5); ++i) {
            const double w = window[i - x + 5] * window[j - y + 5];
            const double va = a.at(i, j)[c], vb = b.at(i, j)[c];
            ma += w * va, mb += w * vb, aa += w * va * va, bb += w * vb * vb, ab += w * va * vb;
          }
        total += (2 * ma * mb + 1e-4) * (2 * (ab - ma * mb) + 9e-4) /
                 ((ma * ma + mb * mb + 1e-4) * (aa - ma * ma + bb - mb * mb + 9e-4));
      }
  return total;
}

double ssim_reference(const Image<double>& a, const Image<double>& b) {
  return ssim_sum(a, b, {}) / (3.0 * a.width * a.height);
}

double loss_reference(const Image<double>& a, const Image<double>& b, double lambda) {
  double l1 = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) l1 += std::abs(a.pixels[i] - b.pixels[i]);
  return (1 - lambda) * l1 / static_cast<double>(a.pixels.size()) +
         lambda * (1 - ssim_reference(a, b));
}

/// The loss whose gradient a masked photo gives: over pixels that count, divided by the number of
/// all; pixels that do not count are those of `present` in both images.
double masked_loss(Image<double> a, Image<double> b, const Mask& used, const Image<double>& present,
                   double lambda) {
  double l1 = 0, counted = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) {
        if (!counts(used, x, y)) a.at(x, y)[c] = b.at(x, y)[c] = present.at(x, y)[c];
        l1 += std::abs(a.at(x, y)[c] - b.at(x, y)[c]);
        counted += counts(used, x, y);
      }
  return ((1 - lambda) * l1 + lambda * (counted - ssim_sum(a, b, used))) /
         (3.0 * a.width * a.height);
}

/// Ones, but for a rectangle that touches the border, some single pixels and a hole.
Mask patchy(int width, int height) {
  Mask used(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool rectangle = x < width / 3 && y > height / 4 && y < height / 2;
      *used.at(x, y) = rectangle || (7 * x + 3 * y) % 29 == 0 ? 0 : 255;
    }
  return used;
}

class Photometric : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Photometric, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

TEST_P(Photometric, ValuesEqualTheDefinition) {
  const Threads threads(2);
  PhotometricLoss loss(threads, GetParam());
  for (auto [w, h] : {std::pair{1, 1}, {4, 9}, {16, 11}, {37, 70}, {64, 33}}) {
    const Image<double> a = noise(w, h, 1), b = noise(w, h, 2);
    const PhotometricSums sums = loss.run(planar(a), planar(b), 0.2);
    EXPECT_NEAR(sums.loss(0.2), loss_reference(a, b, 0.2), 2e-6) << w << "x" << h;
    EXPECT_NEAR(sums.ssim, ssim_reference(a, b), 2e-6) << w << "x" << h;
    EXPECT_NEAR(loss.run(planar(a), planar(a), 0.2).ssim, 1.0, 1e-6);
  }
}

TEST_P(Photometric, GradientEqualsCentralDifferences) {
  const Threads threads(2);
  PhotometricLoss loss(threads, GetParam());
  const int w = 21, h = 40;
  const Image<double> a = noise(w, h, 3), b = noise(w, h, 4);
  loss.run(planar(a), planar(b), 0.2);
  const double step = 1e-5, scale = 1.0 / (3.0 * w * h);
  for (std::size_t i = 0; i < a.pixels.size(); i += test::kSanitized ? 67 : 17) {
    if (std::abs(a.pixels[i] - b.pixels[i]) < 2 * step) continue;
    Image<double> plus = a, minus = a;
    plus.pixels[i] += step;
    minus.pixels[i] -= step;
    const double expected =
        (loss_reference(plus, b, 0.2) - loss_reference(minus, b, 0.2)) / (2 * step);
    const int pixel = static_cast<int>(i / 3);
    const double actual = loss.gradient().row(static_cast<int>(i % 3), pixel / w)[pixel % w];
    EXPECT_NEAR(actual, expected, 1e-4 * scale + 1e-4 * std::abs(expected)) << i;
  }
}

TEST_P(Photometric, MaskedPixelsHaveNoLoss) {
  const Threads threads(2);
  PhotometricLoss loss(threads, GetParam());
  for (auto [w, h] : {std::pair{4, 9}, {37, 70}, {64, 33}}) {
    const Image<double> a = noise(w, h, 1);
    Image<double> b = noise(w, h, 2);
    const Mask used = patchy(w, h);
    const auto count = static_cast<double>(std::ranges::count(used.pixels, 255));
    const PhotometricSums sums = loss.run(planar(a), planar(b), 0.2, used);
    EXPECT_NEAR(sums.loss(0.2) * count / (w * h), masked_loss(a, b, used, a, 0.2), 2e-6);
    // Whatever the photo shows there
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        if (!counts(used, x, y))
          for (int c = 0; c < 3; ++c) b.at(x, y)[c] = 5 - 9 * b.at(x, y)[c];
    const PhotometricSums other = loss.run(planar(a), planar(b), 0.2, used);
    EXPECT_EQ(other.l1, sums.l1);
    EXPECT_EQ(other.ssim, sums.ssim);
  }
  const Image<double> a = noise(20, 20, 1), b = noise(20, 20, 2);
  const PhotometricSums nothing = loss.run(planar(a), planar(b), 0.2, Mask(20, 20, 1));
  EXPECT_EQ(nothing.loss(0.2), 0);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) EXPECT_EQ(loss.gradient().row(1, y)[x], 0);
}

TEST_P(Photometric, AllWhiteIsNoMask) {
  const Threads threads(2);
  PhotometricLoss loss(threads, GetParam()), masked(threads, GetParam());
  const Image<double> a = noise(21, 40, 3), b = noise(21, 40, 4);
  Mask white(21, 40, 1);
  for (auto& v : white.pixels) v = 255;
  const PhotometricSums x = loss.run(planar(a), planar(b), 0.2),
                        y = masked.run(planar(a), planar(b), 0.2, white);
  EXPECT_EQ(x.l1, y.l1);
  EXPECT_EQ(x.ssim, y.ssim);
  for (int c = 0; c < 3; ++c)
    EXPECT_TRUE(std::equal(loss.gradient().plane(c),
                           loss.gradient().plane(c) + loss.gradient().plane_size(),
                           masked.gradient().plane(c)));
}

TEST_P(Photometric, MaskedGradientEqualsCentralDifferences) {
  const Threads threads(2);
  PhotometricLoss loss(threads, GetParam());
  const int w = 21, h = 40;
  const Image<double> a = noise(w, h, 3), b = noise(w, h, 4);
  const Mask used = patchy(w, h);
  loss.run(planar(a), planar(b), 0.2, used);
  const double step = 1e-5, scale = 1.0 / (3.0 * w * h);
  int masked = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += test::kSanitized ? 37 : 7) {
    const int pixel = static_cast<int>(i / 3), x = pixel % w, y = pixel / w;
    const double actual = loss.gradient().row(static_cast<int>(i % 3), y)[x];
    if (!counts(used, x, y)) {
      EXPECT_EQ(actual, 0) << i;
      ++masked;
      continue;
    }
    if (std::abs(a.pixels[i] - b.pixels[i]) < 2 * step) continue;
    Image<double> plus = a, minus = a;
    plus.pixels[i] += step;
    minus.pixels[i] -= step;
    const double expected =
        (masked_loss(plus, b, used, a, 0.2) - masked_loss(minus, b, used, a, 0.2)) / (2 * step);
    EXPECT_NEAR(actual, expected, 1e-4 * scale + 1e-4 * std::abs(expected)) << i;
  }
  EXPECT_GT(masked, test::kSanitized ? 5 : 20);
}

TEST(Background, OfAnImageIsExchanged) {
  Image<double> half(4, 3, 3);
  for (double& v : half.pixels) v = 0.25 * 0.8 + 0.75 * 0.1;  // α of 0.25 over 0.1
  Mask alpha(4, 3, 1);
  for (auto& v : alpha.pixels) v = 51;  // 0.2
  PlanarImage image = planar(half);
  shift_background(alpha, {0.5f, 0, -0.1f}, image);
  EXPECT_NEAR(image.row(0, 1)[2], 0.275 + 0.8 * 0.5, 1e-6);
  EXPECT_NEAR(image.row(1, 1)[2], 0.275, 1e-6);
  EXPECT_NEAR(image.row(2, 1)[2], 0.275 - 0.8 * 0.1, 1e-6);
  EXPECT_EQ(image.row(0, 0)[4], 0) << "the padding stays zero";
  const PlanarImage before = image;
  shift_background({}, {1, 1, 1}, image);
  EXPECT_EQ(largest_difference(before, image), 0) << "opaque";
}

TEST(Psnr, LeavesMaskedPixelsOut) {
  Image<double> a(10, 10, 3), b(10, 10, 3);
  for (double& v : b.pixels) v = 0.1;
  Mask used(10, 10, 1);
  for (int x = 0; x < 10; ++x) *used.at(x, 4) = 255;
  for (int x = 0; x < 10; ++x) b.at(x, 7)[1] = 1;
  EXPECT_NEAR(psnr(planar(a), planar(b), used), 20.0, 1e-4);
  EXPECT_LT(psnr(planar(a), planar(b)), 19.0);
  EXPECT_TRUE(std::isinf(psnr(planar(a), planar(b), Mask(10, 10, 1))));
}

TEST(Psnr, OfAKnownError) {
  Image<double> a(10, 10, 3), b(10, 10, 3);
  for (double& v : b.pixels) v = 0.1;
  EXPECT_NEAR(psnr(planar(a), planar(b)), 20.0, 1e-4);
  EXPECT_TRUE(std::isinf(psnr(planar(a), planar(a))));
}

}  // namespace
}  // namespace fluxgs
