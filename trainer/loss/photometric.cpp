#include "trainer/loss/photometric.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "trainer/core/parameters.h"
#include "trainer/core/psnr.h"

namespace fluxgs {
namespace {

constexpr int kStripRows = 32;  // rows per piece of work

template <class Work>
void for_strips(const Threads& threads, int height, const Work& work) {
  const std::size_t strips = static_cast<std::size_t>((height + kStripRows - 1) / kStripRows);
  threads.for_pieces(3 * strips, 1, [&](std::size_t i, std::size_t) {
    const int begin = static_cast<int>(i % strips) * kStripRows;
    work(static_cast<int>(i / strips), begin, std::min(begin + kStripRows, height));
  });
}

/// A channel of an image and of its target.
SsimArgs ssim_args(const PlanarImage& color, const PlanarImage& target, int channel) {
  SsimArgs a{};
  a.x = color.plane(channel);
  a.y = target.plane(channel);
  a.width = color.width();
  a.height = color.height();
  a.pitch = color.pitch();
  return a;
}

/// Aligned memory of this thread for the kernels, kept from call to call.
float* scratch(const SsimKernels& kernels, const PlanarImage& image) {
  thread_local PlanarFloats buffer;
  const std::size_t size = kernels.scratch_size(image.pitch());
  if (buffer.size() < size) buffer = PlanarFloats(1, size);
  return buffer.data();
}

}  // namespace

void to_planar(const Image<std::uint8_t>& rgb, const Threads& threads, PlanarImage& out) {
  if (out.width() != rgb.width || out.height() != rgb.height)
    out = PlanarImage(rgb.width, rgb.height, 3);
  const auto unpack = ssim_kernels(best_isa()).unpack_rgb;
  threads.for_pieces(
      static_cast<std::size_t>(rgb.height), 32, [&](std::size_t begin, std::size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
          const std::uint8_t* in = rgb.at(0, y);
          if (rgb.channels == 3) {
            unpack(in, static_cast<std::size_t>(rgb.width), out.row(0, y), out.row(1, y),
                   out.row(2, y));
            continue;
          }
          for (int c = 0; c < 3; ++c) {
            float* row = out.row(c, y);
            for (int x = 0; x < rgb.width; ++x)
              row[x] = static_cast<float>(in[x * rgb.channels + c]) * (1.0f / 255.0f);
          }
        }
      });
}

void shift_background(const Image<std::uint8_t>& alpha, const glm::vec3& shift,
                      PlanarImage& image) {
  if (alpha.pixels.empty()) return;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < image.height(); ++y) {
      float* row = image.row(c, y);
      const std::uint8_t* a = alpha.at(0, y);
      for (int x = 0; x < image.width(); ++x)
        row[x] += static_cast<float>(255 - a[x]) * (1.0f / 255.0f) * shift[c];
    }
}

void fill_unused(const Image<std::uint8_t>& used, const PlanarImage& color, PlanarImage& target) {
  if (used.pixels.empty()) return;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < target.height(); ++y) {
      const std::uint8_t* u = used.at(0, y);
      const float* from = color.row(c, y);
      float* to = target.row(c, y);
      for (int x = 0; x < target.width(); ++x) to[x] = u[x] == 0 ? from[x] : to[x];
    }
}

double used_share(const Image<std::uint8_t>& used) {
  if (used.pixels.empty()) return 1;
  const auto masked = std::ranges::count(used.pixels, std::uint8_t{0});
  return 1 - static_cast<double>(masked) / static_cast<double>(used.pixels.size());
}

void PhotometricLoss::prepare(const PlanarImage& color) {
  if (gradient_.width() == color.width() && gradient_.height() == color.height()) return;
  partials_ = PlanarImage(color.width(), color.height(), 9);
  gradient_ = PlanarImage(color.width(), color.height(), 3);
  row_ssim_.resize(3 * static_cast<std::size_t>(color.height()));
  row_l1_.resize(row_ssim_.size());
}

PhotometricSums PhotometricLoss::run(const PlanarImage& color, const PlanarImage& target,
                                     double lambda, const Image<std::uint8_t>& used) {
  const double all = static_cast<double>(color.width()) * color.height();
  if (used.pixels.empty()) return run(color, target, lambda, nullptr, all);
  filled_ = target;
  fill_unused(used, color, filled_);
  if (used_.width() != used.width || used_.height() != used.height)
    used_ = PlanarImage(used.width, used.height, 1);
  copy_mask(used, used_, 0);
  const auto masked = std::ranges::count(used.pixels, std::uint8_t{0});
  return run(color, filled_, lambda, used_.plane(0), all - static_cast<double>(masked));
}

PhotometricSums PhotometricLoss::run(const PlanarImage& color, const PlanarImage& target,
                                     double lambda, const float* used, double count) {
  prepare(color);
  const int height = color.height();
  const double values = 3.0 * color.width() * height;
  const auto args = [&](int c) {
    const std::size_t rows = static_cast<std::size_t>(c) * static_cast<std::size_t>(height);
    SsimArgs a = ssim_args(color, target, c);
    a.used = used;
    for (int p = 0; p < 3; ++p) a.partials[p] = partials_.plane(3 * c + p);
    a.gradient = gradient_.plane(c);
    a.l1_weight = static_cast<float>((1 - lambda) / values);
    a.ssim_weight = static_cast<float>(lambda / values);
    a.row_ssim = row_ssim_.data() + rows;
    a.row_l1 = row_l1_.data() + rows;
    return a;
  };
  for_strips(threads_, height, [&](int c, int begin, int end) {
    kernels_.partials(args(c), begin, end, scratch(kernels_, color));
  });
  for_strips(threads_, height, [&](int c, int begin, int end) {
    kernels_.gradient(args(c), begin, end, scratch(kernels_, color));
  });
  if (count == 0) return {.l1 = 0, .ssim = 1};
  return {std::accumulate(row_l1_.begin(), row_l1_.end(), 0.0) / (3 * count),
          std::accumulate(row_ssim_.begin(), row_ssim_.end(), 0.0) / (3 * count)};
}

PlanarImage loss_map(const PlanarImage& color, const PlanarImage& target, double lambda,
                     const Threads& threads) {
  const SsimKernels& kernels = ssim_kernels(best_isa());
  const int height = color.height();
  PlanarImage ssim(color.width(), height, 3), partials(color.width(), height, 9);
  std::vector<double> row_sums(6 * static_cast<std::size_t>(height));
  for_strips(threads, height, [&](int c, int begin, int end) {
    SsimArgs a = ssim_args(color, target, c);
    for (int p = 0; p < 3; ++p) a.partials[p] = partials.plane(3 * c + p);
    a.values = ssim.plane(c);
    a.row_ssim = row_sums.data() + 2 * c * height;
    a.row_l1 = a.row_ssim + height;
    kernels.partials(a, begin, end, scratch(kernels, color));
  });
  PlanarImage out(color.width(), height, 1);
  const auto l1_weight = static_cast<float>((1 - lambda) / 3);
  const auto ssim_weight = static_cast<float>(lambda / 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < color.width(); ++x)
        out.row(0, y)[x] += l1_weight * std::abs(color.row(c, y)[x] - target.row(c, y)[x]) +
                            ssim_weight * (1 - ssim.row(c, y)[x]);
  return out;
}

double psnr(const PlanarImage& a, const PlanarImage& b, const Image<std::uint8_t>& used) {
  double total = 0;
  std::size_t count = 0;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < a.height(); ++y) {
      const std::uint8_t* counts = used.pixels.empty() ? nullptr : used.at(0, y);
      for (int x = 0; x < a.width(); ++x) {
        if (counts && counts[x] == 0) continue;
        const double d = static_cast<double>(std::clamp(a.row(c, y)[x], 0.0f, 1.0f)) -
                         static_cast<double>(std::clamp(b.row(c, y)[x], 0.0f, 1.0f));
        total += d * d;
        ++count;
      }
    }
  return psnr_of_mse(count == 0 ? 0.0 : total / static_cast<double>(count));
}

}  // namespace fluxgs
