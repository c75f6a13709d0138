// Every renderer against images that were looked at by a person and then kept. The scenes come
// from formulas, so that they are the same everywhere. FLUXGS_UPDATE_GOLDENS=1 rewrites the
// images from the float64 reference; look at them before committing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include <glm/exponential.hpp>

#include "platform/host/host_context.h"
#include "render/renderer.h"
#include "support/scenes.h"
#include "tools/reference/reference_renderer.h"
#include "trainer/data/image_io.h"
#include "trainer/train/evaluate.h"

namespace fluxgs {
namespace {

struct Golden {
  const char* name;
  SplatCloud cloud;
  Camera camera;
  RenderOptions options;
};

void add(SplatCloud& cloud, const glm::vec3& at, const glm::vec3& scale, const glm::quat& rotation,
         float opacity, const glm::vec3& rgb) {
  cloud.positions.push_back(at);
  cloud.log_scales.push_back(glm::log(scale));
  cloud.rotations.push_back(rotation);
  cloud.opacity_logits.push_back(std::log(opacity / (1 - opacity)));
  cloud.sh_dc.push_back((rgb - 0.5f) / 0.28209479f);
  for (int k = 0; k < sh_rest_count(cloud.sh_degree); ++k)
    cloud.sh_rest.push_back(glm::vec3(0.3f, -0.2f, 0.1f) *
                            std::sin(static_cast<float>(k) + at.x * 5));
}

/// A spiral of coloured splats, view-dependent up to degree 3, upright and unlike its mirror image.
Golden spiral() {
  Golden g{"spiral", {}, test::camera_at({0.8, -0.9, -3.2}, {0, 0, 0}, 150, 110), {}};
  g.cloud.sh_degree = 3;
  for (int i = 0; i < 400; ++i) {
    const float t = static_cast<float>(i) / 400, angle = 20 * t;
    const glm::vec3 at(1.2f * t * std::cos(angle), 1.6f * t - 0.8f, 1.2f * t * std::sin(angle));
    add(g.cloud, at, glm::vec3(0.05f, 0.02f + 0.05f * t, 0.03f),
        glm::quat(std::cos(angle), 0.3f, std::sin(angle), 0.1f), 0.35f + 0.6f * t,
        {t, 1 - t, 0.5f + 0.5f * std::sin(9 * t)});
  }
  g.options.background = {0.1, 0.1, 0.15};
  return g;
}

/// Needles that fan out: 400 px long, a few tenths of a pixel wide.
Golden needles() {
  Golden g{"needles", {}, test::camera_in_front(140, 140, 4.0), {}};
  for (int i = 0; i < 24; ++i) {
    const float angle = static_cast<float>(i) * std::numbers::pi_v<float> / 24;
    add(g.cloud,
        {0.4f * std::cos(7 * angle), 0.4f * std::sin(5 * angle), 0.05f * static_cast<float>(i)},
        {1.5f, 1e-5f, 1e-5f}, glm::quat(std::cos(angle / 2), 0, 0, std::sin(angle / 2)), 0.9f,
        {0.5f + 0.5f * std::cos(angle), 0.4f, 0.5f + 0.5f * std::sin(angle)});
  }
  return g;
}

/// The camera inside the cloud: splats behind, across and before the near plane, and far off axis.
Golden inside() {
  Golden g{"inside", {}, test::camera_in_front(131, 97, 0.0, 90), {}};
  for (int i = 0; i < 500; ++i) {
    const float a = 2.399963f * static_cast<float>(i),
                z = 1 - 2 * (static_cast<float>(i) + 0.5f) / 500;
    const float r = std::sqrt(1 - z * z), d = 0.3f + 0.7f * static_cast<float>(i % 7) / 7;
    add(g.cloud, glm::vec3(r * std::cos(a), r * std::sin(a), z) * d, glm::vec3(0.05f),
        glm::quat(1, 0, 0, 0), 0.7f,
        {0.5f + 0.5f * z, 0.5f + 0.5f * r * std::cos(a), 0.5f + 0.5f * std::sin(a)});
  }
  return g;
}

std::vector<Golden> goldens() { return {spiral(), needles(), inside()}; }

std::filesystem::path path_of(const Golden& g) {
  return std::filesystem::path(FLUXGS_GOLDEN_FOLDER) / (std::string(g.name) + ".png");
}

template <class T>
Image<float> to_float(const Image<T>& image) {
  Image<float> out(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = static_cast<float>(image.at(x, y)[c]);
  return out;
}

/// Largest difference to the kept image, in steps of 1/255, beyond the half step of its rounding.
double steps_off(const Golden& g, const Image<float>& image) {
  const auto kept = read_image(path_of(g));
  EXPECT_TRUE(kept) << kept.error().message();
  if (!kept || kept->width != image.width || kept->height != image.height) return 1e9;
  double worst = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double value = 255 * std::clamp(static_cast<double>(image.at(x, y)[c]), 0.0, 1.0);
        const double off = std::abs(value - kept->at(x, y)[c]) - 0.5;
        worst = std::isnan(off) ? 1e9 : std::max(worst, off);
      }
  return worst;
}

TEST(Golden, Reference) {
  const bool update = std::getenv("FLUXGS_UPDATE_GOLDENS") != nullptr;
  for (const Golden& g : goldens()) {
    const Image<float> image = to_float(render_reference(g.cloud, g.camera, g.options).color);
    if (update) {
      ASSERT_TRUE(write_png(path_of(g), image));
    }
    EXPECT_LT(steps_off(g, image), 0.01) << g.name;
  }
}

TEST(Golden, TrainersRasterizer) {
  const Threads threads(2);
  for (const Golden& g : goldens()) {
    const auto planes = cpu_view_renderer(g.cloud, g.options, threads)(g.camera);
    ASSERT_TRUE(planes);
    Image<float> image(planes->width(), planes->height(), 3);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y)[c] = planes->row(c, y)[x];
    EXPECT_LT(steps_off(g, image), 0.15) << g.name;
  }
}

class GoldenGles : public testing::TestWithParam<host::HostGl> {};
INSTANTIATE_TEST_SUITE_P(EveryGl, GoldenGles,
                         testing::Values(host::HostGl::egl, host::HostGl::osmesa,
                                         host::HostGl::angle),
                         [](const auto& gl) { return std::string(host::name(gl.param)); });

TEST_P(GoldenGles, PhonesRenderer) {
  const auto context = host::HostContext::create(GetParam());
  if (!context) GTEST_SKIP() << context.error().message();
  gl::Api& api = (*context)->api();
  const auto renderer = render::Renderer::create(api);
  ASSERT_TRUE(renderer) << renderer.error().message();
  for (const Golden& g : goldens()) {
    ASSERT_TRUE((*renderer)->upload(g.cloud));
    for (auto [format, limit] :
         {std::pair{render::TargetFormat::rgba8, 1.0}, {render::TargetFormat::rgba16f, 1.0}}) {
      const auto target =
          render::RenderTarget::create(api, g.camera.width, g.camera.height, format);
      ASSERT_TRUE(target) << target.error().message();
      ASSERT_TRUE((*renderer)->draw(g.camera, g.options, *target));
      const auto image = (*renderer)->read(*target);
      ASSERT_TRUE(image);
      EXPECT_LT(steps_off(g, to_float(*image)), limit) << g.name;
    }
  }
  for (const gl::DebugMessage& message : api.debug.mistakes())
    ADD_FAILURE() << "the driver complains: " << message.text;
}

}  // namespace
}  // namespace fluxgs
