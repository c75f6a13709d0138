// The projection shader against the formulas in double precision, number by number.
#include <gtest/gtest.h>

#include <bit>
#include <cstdio>
#include <glm/packing.hpp>
#include <map>
#include <numbers>

#include "gl_fixture.h"
#include "render/sort_view.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

struct ProjectedSplat {  // shaders/projected_splat.glsl
  float x, y, xx, xy, yy, level;
  std::uint32_t red_green, blue;

  glm::vec3 color() const { return {glm::unpackHalf2x16(red_green), glm::unpackHalf2x16(blue).x}; }
};
static_assert(sizeof(ProjectedSplat) ==
              render::projected_splat_bytes(render::SplatPrecision::full));

// From ProjectedSplat's factor, whose squares are exponents of 2, to Footprint's.
const double kFromLevels = 1 / std::sqrt(0.5 * std::numbers::log2e);

// The greatest differences from the reference over all splats of an image.
struct Errors {
  double centre = 0;  // px
  double factor = 0;  // relative to the row's length
  double opacity = 0;
  double color = 0;  // relative where above 1
  double depth = 0;  // relative
  std::size_t compared = 0, wrongly_culled = 0, wrongly_kept = 0;
};

bool touches(const ReferenceSplat& s, const Camera& c, double slack) {
  return s.x + s.half_width > -slack && s.x - s.half_width < c.width + slack &&
         s.y + s.half_height > -slack && s.y - s.half_height < c.height + slack;
}

void measure(const ReferenceSplat& s, const ProjectedSplat& r, float depth, Errors& e) {
  const auto worst = [](double& into, double error) { into = std::max(into, std::abs(error)); };
  const double row = std::hypot(s.xx, s.xy);
  worst(e.centre, r.x - s.x);
  worst(e.centre, r.y - s.y);
  worst(e.factor, (r.xx * kFromLevels - s.xx) / row);
  worst(e.factor, (r.xy * kFromLevels - s.xy) / row);
  worst(e.factor, (r.yy * kFromLevels - s.yy) / s.yy);
  worst(e.opacity, std::exp2(r.level) - s.opacity);
  const glm::vec3 color = r.color();
  for (int c = 0; c < 3; ++c) worst(e.color, (color[c] - s.color[c]) / std::max(1.0, s.color[c]));
  worst(e.depth, depth / s.depth - 1);
  ++e.compared;
}

class ProjectionTest : public GlTest {
 protected:
  Errors errors(const SplatCloud& cloud, const Camera& camera, const RenderOptions& options = {}) {
    must(renderer().upload(cloud));
    const auto target = must(render::RenderTarget::create(api(), camera.width, camera.height,
                                                          render::TargetFormat::rgba8));
    must(renderer().set_approximation({.key_bits = 32}));  // The depths with all their bits
    must(renderer().draw(camera, options, target));
    must(renderer().set_approximation({}));
    const render::RenderCloud drawn_from = cloud;
    const render::ScenePacker packer(drawn_from);
    const std::uint32_t nearest =
        render::sort_view(camera, options.near_plane, packer.constants(), 32).keys.low;
    const auto keys = must(renderer().projection().keys().read_all<std::uint32_t>(cloud.size()));
    const auto projected_splats =
        must(renderer().projection().projected_splats().read_all<ProjectedSplat>(cloud.size()));

    std::map<std::uint32_t, ReferenceSplat> wanted;
    for (const ReferenceSplat& s : project_reference(cloud, camera, options)) wanted[s.index] = s;
    Errors e;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      const bool kept = keys[i] != sort::kDropped;
      const auto s = wanted.find(i);
      if (s == wanted.end()) {
        e.wrongly_kept += kept;
      } else if (kept) {
        measure(s->second, projected_splats[i], std::bit_cast<float>(keys[i] + nearest), e);
        e.wrongly_kept += !touches(s->second, camera, 1.0);
      } else {
        e.wrongly_culled += touches(s->second, camera, -0.25);
      }
    }
    return e;
  }

  void expect_small(const std::string& name, const Errors& e) {
    std::printf(
        "%-7s %-22s %5zu splats: centre %.1e px, factor %.1e, opacity %.1e, colour %.1e, "
        "depth %.1e\n",
        std::string(host::name(GetParam())).c_str(), name.c_str(), e.compared, e.centre, e.factor,
        e.opacity, e.color, e.depth);
    EXPECT_GT(e.compared, 0U) << name;
    EXPECT_EQ(e.wrongly_culled, 0U) << name;
    EXPECT_EQ(e.wrongly_kept, 0U) << name;
    EXPECT_LT(e.centre, 2e-3) << name;
    EXPECT_LT(e.factor, 1e-4) << name;
    EXPECT_LT(e.opacity, 1e-6) << name;
    EXPECT_LT(e.color, 1.1e-3) << name;  // Half floats, which some drivers round towards zero
    EXPECT_LT(e.depth, 1e-5) << name;
  }
};

TEST_P(ProjectionTest, EveryDegreeOfSh) {
  for (int stored = 0; stored <= 3; ++stored) {
    const SplatCloud cloud = random_cloud(2000, stored, 1 + static_cast<std::uint32_t>(stored));
    for (int wanted = 0; wanted <= 3; ++wanted)
      expect_small(
          "degree " + std::to_string(wanted) + " of " + std::to_string(stored),
          errors(cloud, orbit_camera(640, 360, {}, 2.5, stored, 4), {.sh_degree = wanted}));
  }
}

TEST_P(ProjectionTest, MixedDegreesOfSh) {
  for (int wanted = 0; wanted <= 3; ++wanted)
    expect_small("degree " + std::to_string(wanted) + " of mixed",
                 errors(mixed_cloud(2000, 5), orbit_camera(640, 360, {}, 2.5, wanted, 4),
                        {.sh_degree = wanted}));
}

TEST_P(ProjectionTest, LightSplatsAreLeftOut) {
  const SplatCloud cloud = random_cloud(3000, 0, 6);
  const Camera camera = orbit_camera(160, 120, {}, 2.5, 1, 4);
  must(renderer().upload(cloud));
  const auto target = must(render::RenderTarget::create(api(), camera.width, camera.height,
                                                        render::TargetFormat::rgba8));
  const auto splats = project_reference(cloud, camera, {});
  const auto weight = [](const ReferenceSplat& s) {
    return 2 * std::numbers::pi * s.opacity / (s.xx * s.yy);
  };
  for (const double least : {1.0, 10.0, 100.0}) {
    must(renderer().set_approximation({.min_weight = least}));
    must(renderer().draw(camera, {}, target));
    must(renderer().set_approximation({}));
    const auto keys = must(renderer().projection().keys().read_all<std::uint32_t>(cloud.size()));
    std::size_t light = 0;
    for (const ReferenceSplat& s : splats) {
      if (!touches(s, camera, -0.25) || std::abs(weight(s) / least - 1) < 1e-3) continue;
      EXPECT_EQ(keys[s.index] == sort::kDropped, weight(s) < least) << weight(s);
      light += weight(s) < least;
    }
    EXPECT_GT(light, 0U) << least;
    EXPECT_LT(light, splats.size()) << least;
  }
}

TEST_P(ProjectionTest, CameraInsideTheCloud) {
  expect_small("inside", errors(random_cloud(3000, 1, 5), orbit_camera(301, 203, {}, 0.3, 1, 3)));
}

TEST_P(ProjectionTest, Needles) {
  SplatCloud cloud = random_cloud(3000, 0, 6);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] = glm::vec3(-12.0F);
    cloud.log_scales[i][static_cast<int>(i % 3)] = -1.0F;
  }
  expect_small("needles", errors(cloud, orbit_camera(640, 360, {}, 2.5, 1, 5)));
}

TEST_P(ProjectionTest, ExtremeScalesAndQuaternions) {
  SplatCloud cloud = random_cloud(3000, 0, 7);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (i % 3 == 0) cloud.log_scales[i] *= 4.0F;  // about −20 … −12
    if (i % 5 == 0) cloud.rotations[i] = cloud.rotations[i] * 1e-30F;
    if (i % 5 == 1) cloud.rotations[i] = cloud.rotations[i] * 1e30F;
    if (i % 5 == 2) cloud.rotations[i] = glm::quat(0, 0, 0, 0);
  }
  expect_small("extremes", errors(cloud, orbit_camera(640, 360, {}, 2.5, 2, 5)));
}

TEST_P(ProjectionTest, FarFromTheOrigin) {
  const glm::vec3 centre(1e5F, -2e5F, 3e4F);
  expect_small("far from the origin", errors(random_cloud(2000, 3, 8, centre),
                                             orbit_camera(640, 360, glm::dvec3(centre), 3, 1, 7)));
}

TEST_P(ProjectionTest, OtherOptions) {
  const RenderOptions options{.alpha_min = 0.02,
                              .filter = ScreenFilter{.dilation = 0.1},
                              .near_plane = 2.0,
                              .frustum_margin = 0.0};
  expect_small("other options",
               errors(random_cloud(2000, 2, 9), orbit_camera(320, 240, {}, 2.2, 3, 7), options));
}

TEST_P(ProjectionTest, CompensatedOpacities) {
  SplatCloud cloud = random_cloud(3000, 0, 12);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] -= 0.001F * static_cast<float>(i);  // to less than a pixel
    if (i % 5 == 0) cloud.log_scales[i].y = -25.0F;
  }
  cloud.filter = {.dilation = 0.1, .compensated = true};
  expect_small("compensated", errors(cloud, orbit_camera(640, 360, {}, 2.5, 1, 5)));
}

TEST_P(ProjectionTest, PrincipalPointOutsideTheImage) {
  Camera camera = orbit_camera(320, 240, {}, 2.2, 3, 7);
  camera.cx = -50;
  camera.cy = 300;
  camera.fy = 1.5 * camera.fx;
  expect_small("off-axis", errors(random_cloud(2000, 2, 10), camera));
}

// The order in which splats are drawn: far to near, and of equal depths the later first.
TEST_P(ProjectionTest, DrawOrder) {
  SplatCloud cloud = random_cloud(5000, 0, 11);
  for (std::size_t i = 0; i < cloud.size(); i += 2) cloud.positions[i].z = 0.25F;
  const Camera camera = front_camera(640, 360, 3);
  EXPECT_GT(errors(cloud, camera).compared, 4000U);
  const std::uint32_t drawn = must(renderer().stats()).drawn;
  const auto keys = must(renderer().projection().keys().read_all<std::uint32_t>(cloud.size()));
  const auto order = must(renderer().sorter().order().read_all<std::uint32_t>(drawn));
  EXPECT_EQ(drawn, std::ranges::count_if(keys, [](auto k) { return k != sort::kDropped; }));
  for (std::size_t i = 1; i < order.size(); ++i) {
    const auto before = std::pair(keys[order[i - 1]], order[i - 1]);
    ASSERT_GT(before, std::pair(keys[order[i]], order[i])) << "at " << i;
  }
}

FLUXGS_GL_TEST_SUITE(ProjectionTest);

}  // namespace
}  // namespace fluxgs::test
