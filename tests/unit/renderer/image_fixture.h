// Images of the renderer beside those of the float64 reference.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "gl_fixture.h"
#include "scenes.h"

namespace fluxgs::test {

inline const RenderOptions kRose{.background = {0.9, 0.6, 0.7}};

class ImageTest : public GlTest {
 protected:
  using Accumulation = render::Accumulation;
  using RenderTarget = render::RenderTarget;
  using TargetFormat = render::TargetFormat;

  Image<float> draw(render::Renderer& with, const Camera& camera, const RenderOptions& options,
                    TargetFormat format, Accumulation accumulation) {
    const RenderTarget target =
        must(RenderTarget::create(api(), camera.width, camera.height, format, accumulation));
    must(with.draw(camera, options, target));
    return must(with.read(target));
  }
  Image<float> draw(const Camera& camera, const RenderOptions& options, TargetFormat format,
                    Accumulation accumulation) {
    return draw(renderer(), camera, options, format, accumulation);
  }

  Accumulation accurate() { return render::accurate_accumulation(api().capabilities); }

  /// The number of splats that the last frame drew. Orders of the CPU, which are what there is
  /// without compute shaders, list some that are not in the image.
  void expect_drawn(std::uint32_t count) {
    const std::uint32_t drawn = must(renderer().stats()).drawn;
    if (GetParam().has_compute()) {
      EXPECT_EQ(drawn, count);
    } else {
      EXPECT_GE(drawn, count);
    }
  }

  void print(const std::string& label, const Difference& d) {
    std::printf("%-7s %-36s PSNR %6.2f dB, greatest error %.5f\n", name_of(GetParam()).c_str(),
                label.c_str(), d.psnr, d.greatest);
  }

  // Draws what was uploaded last and prints a line. The project promises 50 and 45 dB. Where layers
  // are blended in float32 only the last rounding is left, at worst one unit of a half float below
  // 1, half a unit of 8 bits (58.9 dB), and splats at a pixel where their α is that of the cut-off,
  // 1/255, which float32 may draw or not: two of them are allowed.
  void expect_like(const std::string& name, const ReferenceImage& reference, const Camera& camera,
                   const RenderOptions& options, TargetFormat format) {
    const bool exact = accurate() == Accumulation::single_float;
    const bool eight_bit = format == TargetFormat::rgba8;
    const Image<float> image = draw(camera, options, format, accurate());
    const Difference d = compare(image, reference, eight_bit);
    const std::string label = name + (eight_bit ? " RGBA8" : " RGBA16F");
    print(label, d);
    EXPECT_GE(d.psnr, eight_bit ? (exact ? 55 : 45) : (exact ? 65 : 50)) << label;
    if (exact) {
      EXPECT_LE(d.greatest, (eight_bit ? 2.5 : 2.25) / 255) << label;
    }
    keep_image(name_of(GetParam()) + "_" + label, image);
  }

  void expect_like_reference(const std::string& name, const SplatCloud& cloud, const Camera& camera,
                             const RenderOptions& options = {}) {
    must(renderer().upload(cloud));
    const ReferenceImage reference = render_reference(cloud, camera, options);
    for (const TargetFormat format : {TargetFormat::rgba16f, TargetFormat::rgba8})
      expect_like(name, reference, camera, options, format);
  }
};

}  // namespace fluxgs::test
