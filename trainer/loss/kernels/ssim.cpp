#include "trainer/loss/kernels.h"
#include "trainer/simd/lanes.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

// exp(−k²/(2·1.5²)) for k = 0…5, divided by the sum over −5…5
constexpr float kWindow[kSsimRadius + 1] = {0.26601171f, 0.21300553f, 0.10936069f,
                                            0.03600077f, 0.00759876f, 0.00102838f};
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

constexpr int kStep = kLanes;

/// Rows of a strip and its halo that lie inside the picture.
struct Strip {
  int first, last;  // [first, last)
  Strip(int begin, int end, int height)
      : first(begin > kSsimRadius ? begin - kSsimRadius : 0),
        last(end + kSsimRadius < height ? end + kSsimRadius : height) {}
};

/// Scratch memory: `maps` blurred rows for every row of a strip.
struct Rows {
  float* data;
  std::size_t pitch;
  int maps, first;
  float* at(int map, int y) const {
    return data + (static_cast<std::size_t>(y - first) * static_cast<std::size_t>(maps) +
                   static_cast<std::size_t>(map)) *
                      pitch;
  }
};

std::size_t offset(const SsimArgs& a, int y) { return static_cast<std::size_t>(y) * a.pitch; }

/// The window over x, y, x², y², xy along a row.
void blur_moments(const float* x, const float* y, int width, const Rows& out, int row) {
  for (int i = 0; i < width; i += kStep) {
    const Lanes x0 = Lanes::load_unaligned(x + i), y0 = Lanes::load_unaligned(y + i);
    const Lanes w0(kWindow[0]);
    Lanes mx = w0 * x0, my = w0 * y0;
    Lanes xx = mx * x0, yy = my * y0, xy = mx * y0;
    for (int k = 1; k <= kSsimRadius; ++k) {
      const Lanes xl = Lanes::load_unaligned(x + i - k), xr = Lanes::load_unaligned(x + i + k);
      const Lanes yl = Lanes::load_unaligned(y + i - k), yr = Lanes::load_unaligned(y + i + k);
      const Lanes w(kWindow[k]);
      mx = fma(w, xl + xr, mx);
      my = fma(w, yl + yr, my);
      xx = fma(w, fma(xl, xl, xr * xr), xx);
      yy = fma(w, fma(yl, yl, yr * yr), yy);
      xy = fma(w, fma(xl, yl, xr * yr), xy);
    }
    mx.store(out.at(0, row) + i);
    my.store(out.at(1, row) + i);
    xx.store(out.at(2, row) + i);
    yy.store(out.at(3, row) + i);
    xy.store(out.at(4, row) + i);
  }
}

/// The window over one map's column, at lanes i of row y; rows outside the strip are zero.
Lanes blur_column(const Rows& rows, const Strip& strip, int map, int y, int i) {
  Lanes total = Lanes(kWindow[0]) * Lanes::load(rows.at(map, y) + i);
  for (int k = 1; k <= kSsimRadius; ++k) {
    Lanes pair(0.0f);
    if (y - k >= strip.first) pair += Lanes::load(rows.at(map, y - k) + i);
    if (y + k < strip.last) pair += Lanes::load(rows.at(map, y + k) + i);
    total = fma(Lanes(kWindow[k]), pair, total);
  }
  return total;
}

struct Ssim {
  Lanes value, d_mean, d_xx, d_xy;
};

/// SSIM of one window from its moments, and its derivatives.
Ssim ssim(Lanes mx, Lanes my, Lanes xx, Lanes yy, Lanes xy) {
  const Lanes two(2.0f), c1(kC1), c2(kC2);
  const Lanes mxy = mx * my, mxx = mx * mx, myy = my * my;
  const Lanes a1 = fma(two, mxy, c1), a2 = fma(two, xy - mxy, c2);
  const Lanes b1 = mxx + myy + c1, b2 = (xx - mxx) + (yy - myy) + c2;
  const Lanes inverse_b1 = Lanes(1.0f) / b1, inverse_b2 = Lanes(1.0f) / b2;
  const Lanes structure = a2 * inverse_b2, value = a1 * inverse_b1 * structure;
  const Lanes d_xx = -(value * inverse_b2);
  const Lanes d_xy = two * a1 * inverse_b1 * inverse_b2;
  // Through μx directly, and through σx² = E[x²] − μx² and σxy = E[xy] − μx·μy
  const Lanes d_mean =
      two * (my * structure - mx * value) * inverse_b1 - two * mx * d_xx - my * d_xy;
  return {value, d_mean, d_xx, d_xy};
}

}  // namespace

std::size_t ssim_scratch_size(std::size_t pitch, int rows) {
  return 5 * pitch * static_cast<std::size_t>(rows + 2 * kSsimRadius);
}

void ssim_partials(const SsimArgs& a, int begin, int end, float* scratch) {
  const Strip strip(begin, end, a.height);
  const Rows rows{scratch, a.pitch, 5, strip.first};
  for (int y = strip.first; y < strip.last; ++y)
    blur_moments(a.x + offset(a, y), a.y + offset(a, y), a.width, rows, y);
  for (int y = begin; y < end; ++y) {
    Lanes total(0.0f), l1(0.0f);
    for (int i = 0; i < a.width; i += kStep) {
      const auto column = [&](int map) { return blur_column(rows, strip, map, y, i); };
      const Ssim s = ssim(column(0), column(1), column(2), column(3), column(4));
      const LaneMask inside{hn::FirstN(kTag, static_cast<std::size_t>(a.width - i))};
      const std::size_t at = offset(a, y) + static_cast<std::size_t>(i);
      zero_unless(inside, s.d_mean).store_unaligned(a.partials[0] + at);
      zero_unless(inside, s.d_xx).store_unaligned(a.partials[1] + at);
      zero_unless(inside, s.d_xy).store_unaligned(a.partials[2] + at);
      total += zero_unless(inside, s.value);
      l1 += zero_unless(inside,
                        abs(Lanes::load_unaligned(a.x + at) - Lanes::load_unaligned(a.y + at)));
    }
    a.row_ssim[y] = static_cast<double>(sum(total));
    a.row_l1[y] = static_cast<double>(sum(l1));
  }
}

void ssim_gradient(const SsimArgs& a, int begin, int end, float* scratch) {
  const Strip strip(begin, end, a.height);
  const Rows rows{scratch, a.pitch, 3, strip.first};
  for (int y = strip.first; y < strip.last; ++y) {
    for (int map = 0; map < 3; ++map) {
      const float* in = a.partials[map] + offset(a, y);
      for (int i = 0; i < a.width; i += kStep) {
        Lanes total = Lanes(kWindow[0]) * Lanes::load_unaligned(in + i);
        for (int k = 1; k <= kSsimRadius; ++k)
          total = fma(Lanes(kWindow[k]),
                      Lanes::load_unaligned(in + i - k) + Lanes::load_unaligned(in + i + k), total);
        total.store(rows.at(map, y) + i);
      }
    }
  }
  const Lanes zero(0.0f), l1(a.l1_weight), weight(a.ssim_weight);
  for (int y = begin; y < end; ++y) {
    for (int i = 0; i < a.width; i += kStep) {
      const std::size_t at = offset(a, y) + static_cast<std::size_t>(i);
      const Lanes vx = Lanes::load_unaligned(a.x + at), vy = Lanes::load_unaligned(a.y + at);
      const Lanes d = blur_column(rows, strip, 0, y, i) +
                      Lanes(2.0f) * vx * blur_column(rows, strip, 1, y, i) +
                      vy * blur_column(rows, strip, 2, y, i);
      const Lanes sign = select(vx > vy, l1, select(vx < vy, -l1, zero));
      const LaneMask inside{hn::FirstN(kTag, static_cast<std::size_t>(a.width - i))};
      zero_unless(inside, fnma(weight, d, sign)).store_unaligned(a.gradient + at);
    }
  }
}

extern const SsimKernels kSsimKernels;
const SsimKernels kSsimKernels{ssim_scratch_size, ssim_partials, ssim_gradient};

}  // namespace fluxgs::FLUXGS_ISA
