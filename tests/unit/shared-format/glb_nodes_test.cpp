// Transforms of nodes: splats move, turn, grow and stretch with them.
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "glb_support.h"

namespace fluxgs {
namespace {

using namespace test;

// The covariance of a splat, from the specification's formula, independent of the reader.
glm::dmat3 covariance(const SplatCloud& cloud, std::size_t i) {
  const glm::dmat3 r = glm::mat3_cast(glm::normalize(glm::dquat(cloud.rotations[i])));
  glm::dmat3 m = r;
  for (int c = 0; c < 3; ++c) m[c] *= std::exp(double{cloud.log_scales[i][c]});
  return m * glm::transpose(m);
}

const glm::dmat3 kTurn(-1, 0, 0, 0, -1, 0, 0, 0, 1);  // cloud ↔ glTF

// `moved` must be `still` under p ↦ linear·p + shift in glTF's frame, linear = scale·rotation.
void expect_transformed(const SplatCloud& still, const SplatCloud& moved, const glm::dmat3& linear,
                        const glm::dvec3& shift) {
  ASSERT_EQ(still.size(), moved.size());
  const double scale = std::cbrt(glm::determinant(linear));
  const glm::dmat3 all = kTurn * linear * kTurn;
  const glm::dmat3 back = glm::transpose(all) / scale;  // inverse rotation
  double worst_position = 0, worst_covariance = 0, worst_colour = 0;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < still.size(); ++i) {
    const glm::dvec3 expected = all * glm::dvec3(still.positions[i]) + kTurn * shift;
    worst_position =
        std::max(worst_position, glm::length(expected - glm::dvec3(moved.positions[i])));
    const glm::dmat3 s = all * covariance(still, i) * glm::transpose(all);
    const glm::dmat3 difference = s - covariance(moved, i);
    for (int c = 0; c < 3; ++c) {
      worst_covariance = std::max(worst_covariance, glm::length(difference[c]) / glm::length(s[0]));
    }
    const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    worst_colour =
        std::max(worst_colour, glm::length(colour(moved, i, d) - colour(still, i, back * d)));
  }
  EXPECT_LT(worst_position, 1e-5);
  EXPECT_LT(worst_covariance, 1e-3);
  EXPECT_LT(worst_colour, 1e-5);
}

TEST(Glb, AppliesTranslationRotationAndUniformScale) {
  const SplatCloud still = random_cloud(40, 3, 21);
  FLUXGS_UNWRAP(bytes, encode_glb(still, "x"));
  const double h = std::sqrt(0.5);
  const Bytes moved = edited(
      bytes, R"({"mesh":0})",
      fmt::format(R"({{"mesh":0,"translation":[1,2,3],"rotation":[0,{},0,{}],"scale":[2,2,2]}})", h,
                  h));
  FLUXGS_UNWRAP(scene, read(moved));
  const glm::dmat3 quarter(0, 0, -1, 0, 1, 0, 1, 0, 0);  // about y, columns
  expect_transformed(still, scene.cloud, 2.0 * quarter, {1, 2, 3});
}

TEST(Glb, AppliesMatricesAlongTheTree) {
  const SplatCloud still = random_cloud(40, 2, 22);
  FLUXGS_UNWRAP(bytes, encode_glb(still, "x"));
  // Parent: a turn of 0.7 rad about (1,1,1)/√3, half size and a shift; child: a shift.
  const glm::dmat4 parent =
      glm::translate(glm::dmat4(1), glm::dvec3(-1, 0.5, 2)) *
      glm::scale(glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, 1, 1)), glm::dvec3(0.5));
  std::string matrix;
  for (int i = 0; i < 16; ++i) {
    matrix += fmt::format("{}{}", i == 0 ? "" : ",", static_cast<float>(parent[i / 4][i % 4]));
  }
  Bytes moved = edited(bytes, R"({"mesh":0})",
                       fmt::format(R"({{"children":[1],"matrix":[{}]}},)"
                                   R"({{"mesh":0,"translation":[10,0,0]}})",
                                   matrix));
  FLUXGS_UNWRAP(scene, read(moved));
  const glm::dmat3 linear(parent);
  expect_transformed(still, scene.cloud, linear, glm::dvec3(parent * glm::dvec4(10, 0, 0, 1)));
}

// Covariances are exact under any map, colours under turns and mirrors; `exact_colours` tells
// which.
void expect_mapped(const std::string& node, const glm::dmat4& map, int degree, bool exact_colours) {
  const SplatCloud still = random_cloud(40, degree, 23);
  FLUXGS_UNWRAP(bytes, encode_glb(still, "x"));
  FLUXGS_UNWRAP(moved, read(edited(bytes, R"({"mesh":0})", R"({"mesh":0,)" + node + "}")));
  ASSERT_EQ(moved.cloud.size(), still.size());
  EXPECT_EQ(moved.warnings.size(), exact_colours ? 0u : 1u) << node;
  const glm::dmat3 linear = kTurn * glm::dmat3(map) * kTurn;
  const glm::dvec3 shift = kTurn * glm::dvec3(map[3]);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < still.size(); ++i) {
    const glm::dvec3 position = linear * glm::dvec3(still.positions[i]) + shift;
    EXPECT_LT(glm::length(position - glm::dvec3(moved.cloud.positions[i])), 1e-4) << node;
    const glm::dmat3 s = linear * covariance(still, i) * glm::transpose(linear);
    const glm::dmat3 off = s - covariance(moved.cloud, i);
    const double size = s[0][0] + s[1][1] + s[2][2];
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(off[c]), 1e-5 * size) << node;
    if (!exact_colours) continue;
    const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    const glm::dvec3 before = glm::normalize(glm::inverse(linear) * d);
    EXPECT_LT(glm::length(colour(moved.cloud, i, d) - colour(still, i, before)), 1e-5) << node;
  }
}

glm::dmat4 scaling(double x, double y, double z) {
  return glm::scale(glm::dmat4(1), glm::dvec3(x, y, z));
}

TEST(Glb, FollowsMirrorsExactly) {
  for (const int degree : {0, 1, 2, 3}) {
    expect_mapped(R"("scale":[-1,1,1])", scaling(-1, 1, 1), degree, true);
    expect_mapped(R"("scale":[2,-2,2])", scaling(2, -2, 2), degree, true);
    expect_mapped(R"("scale":[-0.5,-0.5,-0.5])", scaling(-0.5, -0.5, -0.5), degree, true);
    // A mirror, then a turn
    expect_mapped(R"("rotation":[0,0.6,0,0.8],"scale":[1,1,-1])",
                  glm::mat4_cast(glm::dquat(0.8, 0, 0.6, 0)) * scaling(1, 1, -1), degree, true);
  }
}

TEST(Glb, FollowsRotationsOfAnyLength) {
  const glm::dmat4 turn = glm::mat4_cast(glm::dquat(0.8, 0, 0.6, 0));
  expect_mapped(R"("rotation":[0,1.2,0,1.6])", turn, 3, true);
  expect_mapped(R"("rotation":[0,6e-9,0,8e-9])", turn, 3, true);
}

TEST(Glb, FollowsStretchesInShapeAndWarnsOfColours) {
  expect_mapped(R"("scale":[1,2,1])", scaling(1, 2, 1), 0, true);
  expect_mapped(R"("scale":[1,2,1])", scaling(1, 2, 1), 2, false);
  expect_mapped(R"("scale":[-3,0.1,1])", scaling(-3, 0.1, 1), 1, false);
  expect_mapped(R"("scale":[1,1,1.0002])", scaling(1, 1, 1.0002), 0, true);
  const glm::dmat4 shear(1, 0.5, 0, 0, 0, 1, -0.25, 0, 0, 0, 1, 0, 3, 4, 5, 1);
  expect_mapped(R"("matrix":[1,0.5,0,0,0,1,-0.25,0,0,0,1,0,3,4,5,1])", shear, 0, true);
  expect_mapped(R"("matrix":[1,0.5,0,0,0,1,-0.25,0,0,0,1,0,3,4,5,1])", shear, 3, false);
  // Nearly even: no warning, and shapes are exact all the same
  const SplatCloud still = random_cloud(5, 2);
  FLUXGS_UNWRAP(bytes, encode_glb(still, "x"));
  FLUXGS_UNWRAP(nearly, read(edited(bytes, R"({"mesh":0})", R"({"mesh":0,"scale":[1,1,1.002]})")));
  EXPECT_TRUE(nearly.warnings.empty());
}

// A stretch inside of a turn inside of a mirror: the node's own map alone says nothing.
TEST(Glb, FollowsUnevenScalesAlongTheTree) {
  const SplatCloud still = random_cloud(30, 0, 24);
  FLUXGS_UNWRAP(bytes, encode_glb(still, "x"));
  FLUXGS_UNWRAP(scene, read(edited(bytes, R"({"mesh":0})",
                                   R"({"children":[1],"scale":[1,3,-1]},)"
                                   R"({"children":[2],"rotation":[0.6,0,0,0.8]},)"
                                   R"({"mesh":0,"scale":[2,1,0.5],"translation":[1,0,0]})")));
  const glm::dmat4 map = scaling(1, 3, -1) * glm::mat4_cast(glm::dquat(0.8, 0.6, 0, 0)) *
                         glm::translate(glm::dmat4(1), glm::dvec3(1, 0, 0)) * scaling(2, 1, 0.5);
  const glm::dmat3 linear = kTurn * glm::dmat3(map) * kTurn;
  for (std::size_t i = 0; i < still.size(); ++i) {
    const glm::dmat3 s = linear * covariance(still, i) * glm::transpose(linear);
    const glm::dmat3 off = s - covariance(scene.cloud, i);
    for (int c = 0; c < 3; ++c)
      EXPECT_LT(glm::length(off[c]), 1e-5 * (s[0][0] + s[1][1] + s[2][2])) << i;
  }
}

TEST(Glb, RefusesTransformsThatSplatsCannotFollow) {
  const Bytes bytes = small_glb();
  const auto with = [&](const std::string& transform) {
    return read(edited(bytes, R"({"mesh":0})", R"({"mesh":0,)" + transform + "}"));
  };
  expect_error(with(R"("scale":[0,0,0])"), {"nodes[0]", "flattens"});
  expect_error(with(R"("scale":[1,0,1])"), {"nodes[0]", "flattens", "no scale of 0"});
  expect_error(with(R"("matrix":[1,0,0,0,1,0,0,0,0,0,1,0,0,0,0,1])"), {"nodes[0]", "flattens"});
  expect_error(
      with(
          R"("translation":[1e308,1e308,0],"matrix":[1e300,0,0,0,0,1e-300,0,0,0,0,1e300,0,0,0,0,1])"),
      {"nodes[0]"});
  expect_error(with(R"("matrix":[1,2,3])"), {"nodes[0].matrix", "16 numbers"});
  expect_error(with(R"("rotation":[0,0,1])"), {"nodes[0].rotation", "4 numbers"});
  expect_error(with(R"("rotation":[0,0,0,0])"), {"nodes[0].rotation", "unit quaternion"});
  expect_error(with(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,0])"),
               {"nodes[0].matrix", "not affine"});
  expect_error(with(R"("matrix":[1,0,0,5,0,1,0,0,0,0,1,0,0,0,0,1])"),
               {"nodes[0].matrix", "last elements"});
  expect_error(with(R"("translation":"up")"), {"nodes[0].translation", "3 numbers"});
  // Beyond float: the splats are left out and counted
  FLUXGS_UNWRAP(far,
                read(edited(bytes, R"({"mesh":0})", R"({"mesh":0,"scale":[1e300,1e300,1e300]})")));
  EXPECT_EQ(far.cloud.size() + far.dropped, 2u);
}

}  // namespace
}  // namespace fluxgs
