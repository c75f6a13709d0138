// L1 + SSIM against a direct float64 evaluation and central differences.
#include "trainer/loss/photometric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

/// Mean SSIM straight from the definition (Wang et al. 2004), zero outside the image.
double ssim_reference(const Image<double>& a, const Image<double>& b) {
  double window[11], total = 0, norm = 0;
  for (int k = 0; k < 11; ++k) norm += window[k] = std::exp(-(k - 5) * (k - 5) / 4.5);
  for (double& w : window) w /= norm;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
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
  return total / (3.0 * a.width * a.height);
}

double loss_reference(const Image<double>& a, const Image<double>& b, double lambda) {
  double l1 = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) l1 += std::abs(a.pixels[i] - b.pixels[i]);
  return (1 - lambda) * l1 / static_cast<double>(a.pixels.size()) +
         lambda * (1 - ssim_reference(a, b));
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
  for (std::size_t i = 0; i < a.pixels.size(); i += 17) {
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

TEST(Psnr, OfAKnownError) {
  Image<double> a(10, 10, 3), b(10, 10, 3);
  for (double& v : b.pixels) v = 0.1;
  EXPECT_NEAR(psnr(planar(a), planar(b)), 20.0, 1e-4);
  EXPECT_TRUE(std::isinf(psnr(planar(a), planar(a))));
}

}  // namespace
}  // namespace fluxgs
