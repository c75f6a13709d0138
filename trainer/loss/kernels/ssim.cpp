#include "trainer/core/lanes.h"
#include "trainer/loss/ssim_kernels.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

// exp(−k²/(2·1.5²)) for k = 0…5, divided by the sum over −5…5
constexpr float kWindow[kSsimRadius + 1] = {0.26601171f, 0.21300553f, 0.10936069f,
                                            0.03600077f, 0.00759876f, 0.00102838f};
constexpr float kC1 = 0.01f * 0.01f, kC2 = 0.03f * 0.03f;

constexpr std::size_t kStep = static_cast<std::size_t>(kLanes);
constexpr std::size_t kGuard = 16;  // zeros at both ends of a blurred row: the window reads there

/// Scratch memory: a row of zeros, which stands for the rows outside the image, and rows that are
/// blurred over their columns and not yet along themselves. The columns come first because they
/// need no neighbouring row's results: nothing is computed twice where strips meet, and what is
/// kept stays in the first-level cache.
struct Scratch {
  static constexpr std::size_t kMaps = 4;
  float* data;
  std::size_t pitch;

  Scratch(float* memory, std::size_t row_pitch) : data(memory), pitch(row_pitch) {
    for (std::size_t i = 0; i < pitch; ++i) data[i] = 0.0f;
    for (std::size_t map = 0; map < kMaps; ++map)
      for (std::size_t i = 0; i < kGuard; ++i) row(map)[i - kGuard] = row(map)[pitch + i] = 0.0f;
  }
  const float* zeros() const { return data; }
  float* row(std::size_t map) const { return data + pitch + kGuard + map * (pitch + 2 * kGuard); }
};

std::size_t offset(const SsimArgs& a, int y) { return static_cast<std::size_t>(y) * a.pitch; }

/// The rows of a plane that the window around row y meets.
struct WindowRows {
  const float* at[2 * kSsimRadius + 1];
  WindowRows(const SsimArgs& a, const float* plane, int y, const float* zeros) {
    for (int k = -kSsimRadius; k <= kSsimRadius; ++k)
      at[k + kSsimRadius] = y + k >= 0 && y + k < a.height ? plane + offset(a, y + k) : zeros;
  }
  Lanes above(int k, std::size_t i) const { return Lanes::load(at[kSsimRadius - k] + i); }
  Lanes below(int k, std::size_t i) const { return Lanes::load(at[kSsimRadius + k] + i); }
};

/// The window's columns over x, y, x² + y² and xy.
void blur_moments(const WindowRows& xs, const WindowRows& ys, const Scratch& out) {
  for (std::size_t i = 0; i < out.pitch; i += kStep) {
    const Lanes x0 = xs.above(0, i), y0 = ys.above(0, i), w0(kWindow[0]);
    Lanes mx = w0 * x0, my = w0 * y0;
    Lanes squares = fma(mx, x0, my * y0), xy = mx * y0;
    for (int k = 1; k <= kSsimRadius; ++k) {
      const Lanes xa = xs.above(k, i), xb = xs.below(k, i);
      const Lanes ya = ys.above(k, i), yb = ys.below(k, i);
      const Lanes w(kWindow[k]);
      mx = fma(w, xa + xb, mx);
      my = fma(w, ya + yb, my);
      squares = fma(w, fma(xa, xa, xb * xb) + fma(ya, ya, yb * yb), squares);
      xy = fma(w, fma(xa, ya, xb * yb), xy);
    }
    mx.store(out.row(0) + i);
    my.store(out.row(1) + i);
    squares.store(out.row(2) + i);
    xy.store(out.row(3) + i);
  }
}

/// The window's columns over one plane.
void blur_columns(const WindowRows& rows, std::size_t pitch, float* out) {
  for (std::size_t i = 0; i < pitch; i += kStep) {
    Lanes total = Lanes(kWindow[0]) * rows.above(0, i);
    for (int k = 1; k <= kSsimRadius; ++k)
      total = fma(Lanes(kWindow[k]), rows.above(k, i) + rows.below(k, i), total);
    total.store(out + i);
  }
}

/// The window along a row, at lanes i.
Lanes blur_along(const float* row, std::size_t i) {
  const float* at = row + i;
  Lanes total = Lanes(kWindow[0]) * Lanes::load(at);
  for (int k = 1; k <= kSsimRadius; ++k)
    total = fma(Lanes(kWindow[k]), Lanes::load_unaligned(at - k) + Lanes::load_unaligned(at + k),
                total);
  return total;
}

struct Ssim {
  Lanes value, d_mean, d_xx, d_xy;
};

/// SSIM of one window from its moments, and its derivatives. Of E[x²] and E[y²] only the sum
/// matters.
Ssim ssim(Lanes mx, Lanes my, Lanes squares, Lanes xy) {
  const Lanes two(2.0f), c1(kC1), c2(kC2);
  const Lanes mxy = mx * my, mean_squares = fma(mx, mx, my * my);
  const Lanes a1 = fma(two, mxy, c1), a2 = fma(two, xy - mxy, c2);
  const Lanes b1 = mean_squares + c1, b2 = (squares - mean_squares) + c2;
  const Lanes inverse_b1 = Lanes(1.0f) / b1, inverse_b2 = Lanes(1.0f) / b2;
  const Lanes structure = a2 * inverse_b2, value = a1 * inverse_b1 * structure;
  const Lanes d_xx = -(value * inverse_b2);
  const Lanes d_xy = two * a1 * inverse_b1 * inverse_b2;
  // Through μx directly, and through σx² = E[x²] − μx² and σxy = E[xy] − μx·μy
  const Lanes d_mean =
      two * (my * structure - mx * value) * inverse_b1 - two * mx * d_xx - my * d_xy;
  return {value, d_mean, d_xx, d_xy};
}

/// Lanes at `at`, column i, that lie in the image and count.
LaneMask counted(const SsimArgs& a, std::size_t at, std::size_t i) {
  const LaneMask inside{hn::FirstN(kTag, static_cast<std::size_t>(a.width) - i)};
  return a.used ? inside & (Lanes::load(a.used + at) > Lanes(0.0f)) : inside;
}

}  // namespace

std::size_t ssim_scratch_size(std::size_t pitch) {
  return pitch + Scratch::kMaps * (pitch + 2 * kGuard);
}

void ssim_partials(const SsimArgs& a, int begin, int end, float* memory) {
  const Scratch rows(memory, a.pitch);
  const std::size_t width = static_cast<std::size_t>(a.width);
  for (int y = begin; y < end; ++y) {
    blur_moments(WindowRows(a, a.x, y, rows.zeros()), WindowRows(a, a.y, y, rows.zeros()), rows);
    Lanes total[kPacks], l1[kPacks];
    for (int p = 0; p < kPacks; ++p) total[p] = l1[p] = Lanes(0.0f);
    for (std::size_t i = 0; i < width; i += kStep) {
      const Ssim s = ssim(blur_along(rows.row(0), i), blur_along(rows.row(1), i),
                          blur_along(rows.row(2), i), blur_along(rows.row(3), i));
      const std::size_t at = offset(a, y) + i;
      const LaneMask inside = counted(a, at, i);
      zero_unless(inside, s.d_mean).store(a.partials[0] + at);
      zero_unless(inside, s.d_xx).store(a.partials[1] + at);
      zero_unless(inside, s.d_xy).store(a.partials[2] + at);
      if (a.values) s.value.store(a.values + at);
      const std::size_t part = i / kStep % kPacks;
      total[part] += zero_unless(inside, s.value);
      l1[part] += abs(Lanes::load(a.x + at) - Lanes::load(a.y + at));  // padding is 0 in both
    }
    a.row_ssim[y] = static_cast<double>(sum(total));
    a.row_l1[y] = static_cast<double>(sum(l1));
  }
}

void ssim_gradient(const SsimArgs& a, int begin, int end, float* memory) {
  const Scratch rows(memory, a.pitch);
  const std::size_t width = static_cast<std::size_t>(a.width);
  const Lanes zero(0.0f), l1(a.l1_weight), weight(a.ssim_weight);
  for (int y = begin; y < end; ++y) {
    for (std::size_t map = 0; map < 3; ++map)
      blur_columns(WindowRows(a, a.partials[map], y, rows.zeros()), a.pitch, rows.row(map));
    for (std::size_t i = 0; i < width; i += kStep) {
      const std::size_t at = offset(a, y) + i;
      const Lanes vx = Lanes::load(a.x + at), vy = Lanes::load(a.y + at);
      const Lanes d = fma(Lanes(2.0f) * vx, blur_along(rows.row(1), i),
                          fma(vy, blur_along(rows.row(2), i), blur_along(rows.row(0), i)));
      const Lanes sign = select(vx > vy, l1, select(vx < vy, -l1, zero));
      zero_unless(counted(a, at, i), fnma(weight, d, sign)).store(a.gradient + at);
    }
  }
}

void unpack_rgb(const std::uint8_t* rgb, std::size_t count, float* r, float* g, float* b) {
  const hn::Rebind<std::uint8_t, Tag> bytes;
  float* rows[3] = {r, g, b};
  const Lanes scale(1.0f / 255.0f);
  std::size_t i = 0;
  for (; i + kStep <= count; i += kStep) {
    hn::Vec<decltype(bytes)> planes[3];
    hn::LoadInterleaved3(bytes, rgb + 3 * i, planes[0], planes[1], planes[2]);
    for (int c = 0; c < 3; ++c)
      (Lanes(hn::ConvertTo(kTag, hn::PromoteTo(kTagI, planes[c]))) * scale).store(rows[c] + i);
  }
  for (; i < count; ++i)
    for (int c = 0; c < 3; ++c)
      rows[c][i] = static_cast<float>(rgb[3 * i + static_cast<std::size_t>(c)]) * (1.0f / 255.0f);
}

extern const SsimKernels kSsimKernels;
const SsimKernels kSsimKernels{ssim_scratch_size, ssim_partials, ssim_gradient, unpack_rgb};

}  // namespace fluxgs::FLUXGS_ISA
