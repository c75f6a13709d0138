// fluxgs convert: what is kept, what is lost and said, and files that are there already.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/io/scene.h"
#include "run_command.h"
#include "small_capture.h"
#include "support/scenes.h"
#include "support/temp_folder.h"

namespace fluxgs {
namespace {

using nlohmann::json;
using test::capture_folder;
using test::expect_error;
using test::files_in;
using test::fluxgs;
using test::Outcome;
using test::quoted;
using test::text_of;
using testing::HasSubstr;
using testing::Not;

TEST(Command, ConvertSaysWhatAFormatCannotHold) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "s.ply", test::random_cloud(10, 3, 1)));
  const auto convert = [&](const std::string& in, const std::string& out) {
    return fluxgs(fmt::format("convert {} {}", quoted(folder / in), quoted(folder / out)));
  };
  const Outcome o = convert("s.ply", "s.splat");
  EXPECT_EQ(o.status, 0);
  EXPECT_NE(o.err.find("s.splat: a .splat stores spherical harmonics up to degree 0"),
            std::string::npos)
      << o.err;
  EXPECT_EQ(convert("s.splat", "t.splat").err.find("SH coefficients"), std::string::npos);
  expect_error(convert("s.ply", "s.gltf"), {"s.gltf", "not written"});
  const json facts =
      json::parse(fluxgs(fmt::format("info {} --json", quoted(folder / "s.splat"))).out);
  EXPECT_EQ(facts["format"], "splat");
  EXPECT_EQ(facts["attributes"]["rotation"], 32);
  EXPECT_EQ(facts["bits_per_splat"], 256);
}

/// `fluxgs convert` between files of a folder.
class Convert : public testing::Test {
 protected:
  Outcome convert(const std::string& in, const std::string& out, const std::string& more = "") {
    return fluxgs(
        fmt::format("convert {} {} {}", quoted(folder_ / in), quoted(folder_ / out), more));
  }
  SceneFile scene(const std::string& name) { return *read_scene(folder_ / name); }
  std::string bytes(const std::string& name) { return text_of(folder_ / name); }

  void SetUp() override {
    cloud_.filter = {0.1f, true};
    ASSERT_TRUE(write_scene(folder_ / "s.ply", cloud_));
    view_.position = {1, 2, 3};
    view_.up = {0, 0, 1};
    const auto glb = encode_glb(cloud_, "s.glb");
    ASSERT_TRUE(write_file_atomic(folder_ / "s.glb", *with_initial_view(*glb, view_, "s.glb")));
  }

  test::TempFolder folder_;
  SplatCloud cloud_ = test::random_cloud(700, 1, 3);
  InitialView view_;
};

TEST_F(Convert, KeepsSoManySplats) {
  constexpr std::size_t kLess = 20, kFew = 7;
  ASSERT_TRUE(write_scene(folder_ / "s.ply", test::random_cloud(50, 1, 1)));
  const Outcome less = convert("s.ply", "less.ply", fmt::format("--max-splats {}", kLess));
  EXPECT_EQ(less.status, 0) << less.err;
  EXPECT_THAT(less.err, HasSubstr(fmt::format("{} of 50 splats are left out", 50 - kLess)));
  EXPECT_EQ(scene("less.ply").cloud.size(), kLess);
  EXPECT_EQ(convert("s.ply", "all.ply", "--max-splats 50").status, 0);
  EXPECT_EQ(scene("all.ply").cloud.size(), 50U);
  ASSERT_EQ(convert("s.ply", "s.glb", "--compact").status, 0);
  EXPECT_EQ(convert("s.glb", "few.glb", fmt::format("--max-splats {}", kFew)).status, 0);
  EXPECT_EQ(scene("few.glb").cloud.size(), kFew) << "a compact file is stored anew";
  EXPECT_EQ(convert("s.ply", "none.ply", "--max-splats 0").status, 2);
}

TEST_F(Convert, TakesLimitsAsPeopleWriteThem) {
  ASSERT_TRUE(write_scene(folder_ / "s.ply", test::random_cloud(1200, 0, 1)));
  for (const char* number : {"1000", "1k", "1K", "1e3", "0.001M"}) {
    const Outcome fewer =
        convert("s.ply", "few.ply", fmt::format("--max-splats {} --force", number));
    ASSERT_EQ(fewer.status, 0) << fewer.err;
    EXPECT_EQ(scene("few.ply").cloud.size(), 1000U) << number;
  }
  EXPECT_EQ(convert("s.ply", "small.glb", "--max-bytes 12kB").status, 0);
  EXPECT_LE(std::filesystem::file_size(folder_ / "small.glb"), 12000U);
  for (const char* odd : {"1kB", "0", "0.5", "-1k", "nan", "inf", "1e99", "k", "1kk", "0x10"}) {
    const Outcome refused = convert("s.ply", "odd.ply", fmt::format("--max-splats={}", odd));
    EXPECT_EQ(refused.status, 2) << odd;
    EXPECT_THAT(refused.err, HasSubstr("expected a whole number from 1 to 1099511627776, such as "
                                       "50000 or 50k"));
  }
}

// An impossible limit is refused before any search.
TEST_F(Convert, BytesBelowThoseOfOneSplatAreRefused) {
  ASSERT_TRUE(write_scene(folder_ / "s.ply", test::random_cloud(200, 1, 1)));
  ASSERT_EQ(convert("s.ply", "one.glb", "--compact --max-splats 1").status, 0);
  const auto one = std::filesystem::file_size(folder_ / "one.glb");
  const Outcome refused = convert("s.ply", "t.glb", "--max-bytes 500");
  expect_error(refused, {"t.glb: size: one splat takes", "expected 500 at most; --sh-degree 0"});
  std::size_t least = 0;
  std::istringstream(refused.err.substr(refused.err.find("takes ") + 6)) >> least;
  EXPECT_LE(least, one);
  EXPECT_GE(4 * least, 3 * one);  // whose harmonics are not zeros
}

TEST_F(Convert, ReplacesNothingUnlessForced) {
  ASSERT_EQ(convert("s.glb", "t.ply").status, 0);
  const std::string first = bytes("t.ply");
  const Outcome second = convert("s.ply", "t.ply", "--sh-degree 0");
  EXPECT_EQ(second.status, 0);
  EXPECT_THAT(second.err, HasSubstr("t.ply: existed, and is kept as t.ply.~1~ (--force"));
  EXPECT_EQ(bytes("t.ply.~1~"), first);
  EXPECT_EQ(scene("t.ply").cloud.sh_degree, 0);
  const std::string before = bytes("t.ply");
  ASSERT_EQ(convert("s.ply", "t.ply").status, 0);
  EXPECT_EQ(bytes("t.ply.~2~"), before);
  EXPECT_EQ(bytes("t.ply.~1~"), first);
  ASSERT_EQ(convert("s.ply", "t.ply", "--force").status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "t.ply.~3~"));
  // A conversion that fails leaves everything as it was
  const std::size_t files = files_in(folder_.path());
  expect_error(convert("missing.ply", "t.ply"), {"missing.ply"});
  EXPECT_EQ(files_in(folder_.path()), files);
  std::filesystem::create_directory(folder_ / "folder.ply");
  expect_error(convert("s.ply", "folder.ply"), {"folder.ply", "is a folder", "name of a file"});
}

TEST_F(Convert, AFolderInPlaceOfASceneIsExplained) {
  std::filesystem::create_directories(folder_ / "run/point_cloud/iteration_7000");
  std::filesystem::copy(folder_ / "s.ply",
                        folder_ / "run/point_cloud/iteration_7000/point_cloud.ply");
  expect_error(convert("run", "t.ply"), {"run", "is a folder", "iteration_7000/point_cloud.ply"});
  std::filesystem::create_directory(folder_ / "empty");
  expect_error(convert("empty", "t.ply"), {"empty", "without a scene"});
  expect_error(fluxgs(fmt::format("info {}", quoted(capture_folder()))),
               {"is a folder of photos", "fluxgs train"});
}

// One splat far away is no reason to round all others.
TEST_F(Convert, AStraySplatDoesNotCoarsenTheOthers) {
  SplatCloud cloud = test::random_cloud(2000, 0, 1);
  cloud.positions[7] = glm::vec3(1e7F, 0, 0);
  ASSERT_TRUE(write_scene(folder_ / "stray.ply", cloud));
  for (const char* out : {"out.glb --compact", "out.compressed.ply"}) {
    const Outcome run = fluxgs(fmt::format(
        "convert {} {}/{} --force", quoted(folder_ / "stray.ply"), folder_.path().string(), out));
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("1 of 2000 splats lie so far away"));
    const std::string name = std::string(out).substr(0, std::string_view(out).find(' '));
    const auto written = read_scene(folder_ / name);
    ASSERT_TRUE(written);
    double worst = 0;
    for (const glm::vec3& p : cloud.positions) {
      if (p.x > 1e6F) continue;
      double nearest = 1e9;
      for (const glm::vec3& q : written->cloud.positions)
        nearest = std::min(nearest, static_cast<double>(glm::distance(p, q)));
      worst = std::max(worst, nearest);
    }
    EXPECT_LT(worst, 0.1) << out;
  }
}

// A stray splat is a half or a third of so few.
TEST_F(Convert, AStraySplatOfTwoOrThreeDoesNotCoarsenTheOthers) {
  for (const std::size_t size : {2U, 3U, 5U})
    for (const bool far : {true, false}) {
      SplatCloud cloud = test::random_cloud(size, 0, 1);
      for (glm::vec3& s : cloud.log_scales) s = glm::vec3(-2, -2.5F, -3);
      cloud.opacity_logits.assign(size, 2);
      if (far)
        cloud.positions.back() = glm::vec3(1e30F, 0, 0);
      else
        cloud.log_scales.back() = glm::vec3(50);
      ASSERT_TRUE(write_scene(folder_ / "few.ply", cloud));
      const Outcome run =
          fluxgs(fmt::format("convert --compact --force {} {}", quoted(folder_ / "few.ply"),
                             quoted(folder_ / "few.glb")));
      ASSERT_EQ(run.status, 0) << run.err;
      EXPECT_THAT(run.err, HasSubstr(fmt::format("1 of {} splats", size)));
      const auto written = read_scene(folder_ / "few.glb");
      ASSERT_TRUE(written);
      for (std::size_t i = 0; i + 1 < size; ++i) {
        std::size_t nearest = 0;
        const auto away = [&](std::size_t k) {
          return glm::distance(cloud.positions[i], written->cloud.positions[k]);
        };
        for (std::size_t k = 1; k < size; ++k)
          if (away(k) < away(nearest)) nearest = k;
        EXPECT_LT(away(nearest), 0.1) << size << far;
        std::array<float, 3> sizes{}, found{};
        for (int c = 0; c < 3; ++c) {
          sizes[static_cast<std::size_t>(c)] = cloud.log_scales[i][c];
          found[static_cast<std::size_t>(c)] = written->cloud.log_scales[nearest][c];
        }
        std::ranges::sort(sizes);
        std::ranges::sort(found);
        EXPECT_THAT(found, testing::Pointwise(testing::FloatNear(0.7F), sizes)) << size << far;
      }
    }
}

// Tiny splats are no outliers: --crop could leave out nothing.
TEST_F(Convert, TinySplatsAreNotCalledFarAway) {
  SplatCloud cloud = test::random_cloud(200, 0, 1);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.log_scales[i] = glm::vec3(i % 2 == 0 ? -90 : -100);
  ASSERT_TRUE(write_scene(folder_ / "tiny.ply", cloud));
  const Outcome run = fluxgs(fmt::format("convert --compact {} {}", quoted(folder_ / "tiny.ply"),
                                         quoted(folder_ / "tiny.glb")));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("smaller than the scene"));
  EXPECT_THAT(run.err, testing::Not(HasSubstr("--crop")));
}

TEST_F(Convert, AnEmptySceneStaysOne) {
  ASSERT_TRUE(write_scene(folder_ / "none.ply", SplatCloud()));
  const Outcome run = fluxgs(fmt::format("convert --compact {} {}", quoted(folder_ / "none.ply"),
                                         quoted(folder_ / "none.glb")));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, testing::Not(HasSubstr("compact")));
  EXPECT_THAT(fluxgs("info " + quoted(folder_ / "none.glb")).out,
              testing::Not(HasSubstr("no node")));
}

TEST_F(Convert, AStrongColorDoesNotCoarsenTheOthers) {
  const SplatCloud plain = test::random_cloud(2000, 1, 1);
  SplatCloud cloud = plain;
  cloud.sh_dc[7].y = 1e12F;
  cloud.sh_rest[30].x = -1e8F;
  ASSERT_TRUE(write_scene(folder_ / "plain.ply", plain));
  ASSERT_TRUE(write_scene(folder_ / "strong.ply", cloud));
  for (const char* out : {"out.glb", "out.compressed.ply", "out.sog"}) {
    const auto write = [&](const char* in) {
      const bool compact = std::string_view(out).ends_with(".glb");
      const Outcome run = fluxgs(fmt::format("convert {} {} --force {}", quoted(folder_ / in),
                                             quoted(folder_ / out), compact ? "--compact" : ""));
      EXPECT_EQ(run.status, 0) << run.err;
      const auto warning = HasSubstr("the colours of 2 of 2000 splats");
      if (std::string_view(in) == "strong.ply") {
        EXPECT_THAT(run.err, warning);
      } else {
        EXPECT_THAT(run.err, testing::Not(warning));
      }
      return scene(out).cloud;
    };
    const SplatCloud expected = write("plain.ply"), written = write("strong.ply");
    ASSERT_EQ(written.size(), expected.size());
    double sum = 0;
    for (std::size_t i = 0; i < written.size(); ++i)
      sum += std::min(glm::distance(written.sh_dc[i], expected.sh_dc[i]), 10.0F);
    EXPECT_LT(sum / static_cast<double>(written.size()), 0.2) << out;
  }
}

TEST_F(Convert, CompactScenesStayCompact) {
  ASSERT_EQ(convert("s.glb", "c.glb", "--compact").status, 0);
  ASSERT_EQ(convert("c.glb", "d.glb").status, 0);
  EXPECT_EQ(bytes("d.glb"), bytes("c.glb"));
  const Outcome turned = convert("c.glb", "e.glb", "--rotate 0,0,90 --scale 2");
  EXPECT_THAT(turned.out, HasSubstr("compact"));
  EXPECT_THAT(scene("e.glb").extensions, testing::Contains("FLUXGS_gaussian_splatting_compact"));
  ASSERT_EQ(convert("c.glb", "less.glb", "--sh-degree 0").status, 0);
  EXPECT_THAT(scene("less.glb").extensions, testing::Contains("FLUXGS_gaussian_splatting_compact"));
  ASSERT_EQ(convert("c.glb", "f.glb", "--no-compact").status, 0);
  EXPECT_EQ(scene("f.glb").extensions, std::vector<std::string>{"KHR_gaussian_splatting"});
  EXPECT_EQ(scene("f.glb").cloud.positions, scene("c.glb").cloud.positions);
  for (const char* name : {"c.glb", "d.glb", "e.glb", "f.glb"}) {
    EXPECT_EQ(scene(name).cloud.filter, cloud_.filter) << name;
    EXPECT_TRUE(scene(name).start) << name;
  }
  EXPECT_EQ(convert("c.glb", "g.glb", "--compact --no-compact").status, 2);
}

TEST_F(Convert, TurnsResizesAndMovesSplatsAndStart) {
  ASSERT_EQ(convert("s.glb", "t.glb", "--rotate 0,0,90 --scale 2 --translate 1,-1,0.5").status, 0);
  const SceneFile turned = scene("t.glb");
  for (std::size_t i = 0; i < cloud_.size(); ++i) {
    const glm::vec3 p = cloud_.positions[i];
    EXPECT_LT(glm::length(turned.cloud.positions[i] -
                          glm::vec3(-2 * p.y + 1, 2 * p.x - 1, 2 * p.z + 0.5f)),
              1e-4);
    EXPECT_NEAR(turned.cloud.log_scales[i].x, cloud_.log_scales[i].x + std::log(2), 1e-5);
    // Degree 1 is −y, z, −x; colours seen along x are then seen along y
    const glm::vec3 *was = &cloud_.sh_rest[3 * i], *is = &turned.cloud.sh_rest[3 * i];
    EXPECT_LT(glm::length(is[0] - was[2]), 1e-5);
    EXPECT_LT(glm::length(is[1] - was[1]), 1e-5);
    EXPECT_LT(glm::length(is[2] + was[0]), 1e-5);
  }
  ASSERT_TRUE(turned.start);
  EXPECT_LT(glm::length(turned.start->position - glm::dvec3(-3, 1, 6.5)), 1e-9);
  EXPECT_LT(glm::length(turned.start->up - glm::dvec3(0, 0, 1)), 1e-9);

  ASSERT_EQ(convert("s.glb", "up.glb", "--up z").status, 0);
  const SceneFile upright = scene("up.glb");
  for (std::size_t i = 0; i < cloud_.size(); ++i)
    EXPECT_NEAR(upright.cloud.positions[i].y, -cloud_.positions[i].z, 1e-5);
  EXPECT_LT(glm::length(upright.start->up - glm::dvec3(0, -1, 0)), 1e-9);
  ASSERT_EQ(convert("s.ply", "same.ply", "--up -y --rotate 0,0,0 --scale 1").status, 0);
  EXPECT_EQ(scene("same.ply").cloud.positions, cloud_.positions);
  ASSERT_EQ(convert("s.ply", "down.ply", "--up 0,5,0").status, 0);
  EXPECT_EQ(scene("down.ply").cloud.positions[3].y, -cloud_.positions[3].y);
  for (const char* wrong :
       {"--up w", "--up 0,0,0", "--up 1,2", "--up --", "--rotate 1,2", "--rotate a,b,c",
        "--rotate 1,2,nan", "--scale 0", "--scale -1", "--scale nan", "--translate 1e300,0,0"})
    EXPECT_EQ(convert("s.ply", "w.ply", wrong).status, 2) << wrong;
}

TEST_F(Convert, KeepsThePartThatIsAskedFor) {
  const auto expect_kept = [&](const std::string& options, const auto& keep) {
    const Outcome o = convert("s.ply", "part.ply", "--force " + options);
    ASSERT_EQ(o.status, 0) << o.err;
    std::vector<glm::vec3> expected;
    for (std::size_t i = 0; i < cloud_.size(); ++i)
      if (keep(i)) expected.push_back(cloud_.positions[i]);
    ASSERT_GT(expected.size(), 0u) << options;
    ASSERT_LT(expected.size(), cloud_.size()) << options;
    EXPECT_EQ(scene("part.ply").cloud.positions, expected) << options;
    EXPECT_THAT(o.err,
                HasSubstr(fmt::format("{} splats are left out", cloud_.size() - expected.size())));
  };
  const auto& p = cloud_.positions;
  expect_kept("--crop -100,0,-100,100,100,100", [&](std::size_t i) { return p[i].y >= 0; });
  expect_kept("--crop-sphere 0.1,0,0,0.8",
              [&](std::size_t i) { return glm::distance(glm::dvec3(p[i]), {0.1, 0, 0}) <= 0.8; });
  expect_kept("--min-opacity 0.5", [&](std::size_t i) { return cloud_.opacity_logits[i] >= 0; });
  expect_kept("--min-opacity 0.5 --crop=-100,-100,-100,0,100,100",
              [&](std::size_t i) { return cloud_.opacity_logits[i] >= 0 && p[i].x <= 0; });

  // A compact file stays compact, and keeps its start view
  ASSERT_EQ(convert("s.glb", "c.glb", "--compact").status, 0);
  ASSERT_EQ(convert("c.glb", "half.glb", "--crop -100,0,-100,100,100,100").status, 0);
  EXPECT_LT(scene("half.glb").cloud.size(), cloud_.size());
  EXPECT_TRUE(scene("half.glb").start);

  expect_error(convert("s.ply", "w.ply", "--crop-sphere 1e6,0,0,1"),
               {"s.ply: none of its 700 splats is within --crop-sphere; fluxgs info"});
  for (const char* wrong : {"--crop 1,2,3", "--crop 1,0,0,0,1,1", "--crop 0,0,0,1,1,nan",
                            "--crop-sphere 0,0,0,0", "--crop-sphere 0,0,0,-1", "--min-opacity 2"})
    EXPECT_EQ(convert("s.ply", "w.ply", wrong).status, 2) << wrong;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "w.ply"));
}

TEST_F(Convert, SaysWhatAFormatLoses) {
  const Outcome splat = convert("s.glb", "t.splat");
  EXPECT_THAT(splat.err, HasSubstr("t.splat: the scene's screen filter (a blur of 0.1 px², "
                                   "antialiased) is left out"));
  EXPECT_THAT(splat.err, HasSubstr("t.splat: the scene's start view and up are left out"));
  EXPECT_THAT(splat.err, HasSubstr("t.splat: rounded, at most: shapes "));
  EXPECT_THAT(splat.err, HasSubstr("up to degree 0"));
  const Outcome glb = convert("s.glb", "t.glb");
  EXPECT_EQ(glb.status, 0);
  EXPECT_EQ(glb.err, "");
  EXPECT_THAT(convert("s.glb", "c.glb", "--compact").err,
              HasSubstr("rounded, at most: positions "));
}

TEST_F(Convert, ErrorsOfReorderedFilesAreThoseOfTheSameSplats) {
  cloud_.positions[3].x = 1000;  // far from all others
  ASSERT_TRUE(write_scene(folder_ / "far.ply", cloud_));
  for (const char* name : {"far.sog", "far.compressed.ply"}) {
    const Outcome o = convert("far.ply", name);
    ASSERT_EQ(o.status, 0) << o.err;
    const std::size_t at = o.err.rfind("positions ");
    ASSERT_NE(at, std::string::npos) << o.err;
    EXPECT_LT(std::stod(o.err.substr(at + 10)), 5) << o.err;
    const std::size_t opacities = o.err.find("opacities ");
    ASSERT_NE(opacities, std::string::npos) << o.err;
    EXPECT_LT(std::stod(o.err.substr(opacities + 10)), 0.01) << o.err;
  }
}

TEST_F(Convert, WritesAttributesOfFewerBits) {
  const Outcome o = convert("s.glb", "q.glb", "--quantize-attributes 8");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("q.glb: rounded, at most: shapes "));
  EXPECT_THAT(o.err, Not(HasSubstr("positions")));
  const SceneFile q = scene("q.glb");
  EXPECT_EQ(q.attribute_bits.at("rotation"), 32);
  EXPECT_TRUE(q.start);
  EXPECT_EQ(q.cloud.filter, cloud_.filter);
  const json facts =
      json::parse(fluxgs(fmt::format("info {} --json", quoted(folder_ / "q.glb"))).out);
  EXPECT_EQ(facts["antialiased"], true);
  EXPECT_NEAR(facts["dilation"].get<double>(), 0.1, 1e-6);
  EXPECT_EQ(convert("s.ply", "w.glb", "--quantize-attributes 7").status, 2);
  EXPECT_EQ(convert("s.ply", "w.glb", "--quantize-attributes 8 --compact").status, 2);
  expect_error(convert("s.ply", "w.spz", "--quantize-attributes 8"), {"w.spz", "expected .glb"});
}

TEST(Command, CompactScenesAreSearchedForAndReportedOn) {
  const test::TempFolder folder;
  const auto scene = folder / "scene.ply";
  ASSERT_TRUE(write_scene(scene, test::random_cloud(500, 1)));
  const std::string data = " --data " + quoted(capture_folder());  // small views
  const auto run = [&](const std::string& more) {
    return fluxgs(
        fmt::format("convert {} {} --force {}", quoted(scene), quoted(folder / "c.glb"), more));
  };
  EXPECT_EQ(run("--compact").status, 0);
  const auto standard = std::filesystem::file_size(folder / "c.glb");
  EXPECT_EQ(run("--compact --step-scale 2 --sh-degree 0").status, 0);
  EXPECT_LT(std::filesystem::file_size(folder / "c.glb"), standard);
  const Outcome bytes = run("--max-bytes 5000" + data);
  EXPECT_EQ(bytes.status, 0) << bytes.err;
  EXPECT_THAT(bytes.out, HasSubstr(" of 500 splats, ")) << "fewer, with more bits each";
  EXPECT_LE(std::filesystem::file_size(folder / "c.glb"), 5000u);
  const auto from_start = folder / "start.glb";
  const auto glb = encode_glb(test::random_cloud(500, 1), "start.glb");
  ASSERT_TRUE(write_file_atomic(from_start, *with_initial_view(*glb, {}, "start.glb")));
  EXPECT_EQ(fluxgs(fmt::format("convert {} {} --force --max-bytes 5000{}", quoted(from_start),
                               quoted(folder / "c.glb"), data))
                .status,
            0);
  EXPECT_LE(std::filesystem::file_size(folder / "c.glb"), 5000u);
  EXPECT_TRUE(read_scene(folder / "c.glb")->start);
  const Outcome loss = run("--min-psnr 35" + data);
  EXPECT_EQ(loss.status, 0) << loss.err;
  EXPECT_NE(loss.out.find(" dB from the images of "), std::string::npos) << loss.err;
  EXPECT_EQ(read_scene(folder / "c.glb")->cloud.size(), 500u);

  expect_error(run("--max-bytes 100" + data), {"c.glb: size", "expected 100 at most"});
  EXPECT_EQ(run("--step-scale 2").status, 2);
  EXPECT_EQ(run("--min-psnr nan").status, 2);
  EXPECT_EQ(run("--compact" + data).status, 2);
  EXPECT_EQ(run("--plain-attributes").status, 2);
  EXPECT_EQ(run("--max-bytes 100 --min-psnr 30").status, 2);
  expect_error(
      fluxgs(fmt::format("convert {} {} --compact", quoted(scene), quoted(folder / "c.spz"))),
      {"c.spz: extension", "expected .glb"});

  const Outcome report = fluxgs(fmt::format("report codec {} --compare {} --json - {}",
                                            quoted(scene), quoted(folder / "c.glb"), data));
  ASSERT_EQ(report.status, 0) << report.err;
  const json numbers = json::parse(report.out);
  double last = 0;
  int curve = 0;
  for (const json& row : numbers.at("rows")) {
    EXPECT_GT(row.at("bits_per_splat").get<double>(), 5);
    if (!row.at("name").get<std::string>().starts_with("compact")) continue;
    ++curve;
    if (last > 0) {
      EXPECT_LT(row.at("psnr").get<double>(), last);
    }
    last = row.at("psnr").get<double>();
  }
  EXPECT_GE(curve, 7);
  expect_error(fluxgs(fmt::format("report codec {} --plot x.pdf", quoted(scene))),
               {"x.pdf: --plot", ".png or .svg"});
}

TEST(Reports, MeasureLpipsOfEveryFile) {
  const test::TempFolder folder;
  const auto scene = folder / "scene.ply";
  ASSERT_TRUE(write_scene(scene, test::random_cloud(200, 1, 9)));
  const std::string data = " --data " + quoted(capture_folder());
  for (const char* kind : {"codec", "sizes --counts 2"}) {
    const std::string report = fmt::format("report {} {} --lpips alex", kind, quoted(scene));
    expect_error(fluxgs(report), {"--lpips", "no test images", "expected --data"});
    expect_error(fluxgs(report + data, "FLUXGS_LPIPS=" + quoted(folder / "none")),
                 {"alex.onnx", "tools/deps/lpips"});
    const Outcome measured = fluxgs(report + " --json -" + data);
    if (measured.err.find("tools/deps/lpips") != std::string::npos) GTEST_SKIP() << measured.err;
    ASSERT_EQ(measured.status, 0) << measured.err;
    const json found = json::parse(measured.out);
    EXPECT_EQ(found.at("lpips"), "alex");
    for (const json& row : found.at("rows")) {
      EXPECT_GT(row.at("view_lpips").at("zero_to_one").get<double>(), 0);
      EXPECT_GT(row.at("view_lpips").at("minus_one_to_one").get<double>(), 0);
    }
  }
}

TEST(ReportSizes, HasErrorsOfEachSize) {
  const test::TempFolder folder;
  const auto scene = folder / "scene.ply";
  ASSERT_TRUE(write_scene(scene, test::random_cloud(400, 1, 9)));
  const Outcome report = fluxgs(fmt::format("report sizes {} --counts 3 --data {} --json -",
                                            quoted(scene), quoted(capture_folder())));
  ASSERT_EQ(report.status, 0) << report.err;
  const json rows = json::parse(report.out).at("rows");
  ASSERT_EQ(rows.size(), 9U);
  std::size_t smallest = 1000000;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at("splats"), (std::array{400, 280, 196})[i / 3]);
    EXPECT_TRUE(rows[i].at("view_psnr").is_number());
    if (i % 3 > 0) {
      EXPECT_LT(rows[i].at("bytes"), rows[i - 1].at("bytes"));
    }
    smallest = std::min(smallest, rows[i].at("bytes").get<std::size_t>());
  }
  for (const json& row : rows)
    if (row.at("bytes") == smallest) {
      EXPECT_TRUE(row.at("on_front"));
    }
  EXPECT_EQ(fluxgs(fmt::format("report sizes {} --counts 0", quoted(scene))).status, 2);
  expect_error(fluxgs(fmt::format("report sizes {} --plot x.pdf", quoted(scene))),
               {"x.pdf: --plot", ".png or .svg"});
}

}  // namespace
}  // namespace fluxgs
