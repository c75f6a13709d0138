// fluxgs bench, as people call it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "fluxgs/io/scene.h"
#include "run_command.h"
#include "support/scenes.h"

namespace fluxgs {
namespace {

using nlohmann::json;
using test::expect_error;
using test::fluxgs;
using test::Outcome;
using test::quoted;

class BenchCommand : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = folder_ / "scene.ply";
    SplatCloud cloud;
    cloud.sh_degree = 1;
    cloud.resize(2000);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto t = static_cast<float>(i);
      cloud.positions[i] = {std::sin(t), 0.001F * t - 1, std::cos(t)};
      cloud.log_scales[i] = glm::vec3(-3.0F);
      cloud.rotations[i] = {1, 0, 0, 0};
    }
    ASSERT_TRUE(write_scene(scene_, cloud));
  }

  json bench(const std::string& options) {
    const Outcome o =
        fluxgs("bench " + quoted(scene_) + " --size 96x64 --frames 3 --warmup 1 --json " + options);
    EXPECT_EQ(o.status, 0) << o.err;
    return json::parse(o.out, nullptr, false);
  }

  test::TempFolder folder_;
  std::filesystem::path scene_;
};

TEST_F(BenchCommand, SaysWhatTheContractPromises) {
  const json r = bench("");
  for (const char* key :
       {"gl_renderer", "size", "frames", "in_flight_ms", "draw_ms", "sort_to_display_ms", "stages",
        "bytes_per_frame", "splats_drawn", "load_ms", "peak_memory_bytes"})
    EXPECT_TRUE(r.contains(key)) << key;
  for (const char* key : {"in_flight_ms", "draw_ms", "sort_to_display_ms"}) {
    EXPECT_GT(r[key]["median"].get<double>(), 0);
    EXPECT_GE(r[key]["p95"].get<double>(), r[key]["median"].get<double>());
  }
  EXPECT_EQ(r["size"], json({96, 64}));
  EXPECT_EQ(r["frames"], 3);
  EXPECT_EQ(r["splats_drawn"], 2000);
  EXPECT_GT(r["bytes_per_frame"].get<double>(), 2000 * 100);
}

TEST_F(BenchCommand, SettingsReachTheRenderer) {
  EXPECT_EQ(bench("--min-weight 1e6")["splats_drawn"], 0);
  const json standard = bench(""), half = bench("--splat-precision half"),
             small = bench("--scale 0.5");
  EXPECT_LT(half["traffic"]["vertices"], standard["traffic"]["vertices"]);
  EXPECT_LT(half["gpu_memory_bytes"], standard["gpu_memory_bytes"]);
  EXPECT_LT(small["fragments"], standard["fragments"]);
  EXPECT_LT(bench("--key-bits 16")["traffic"]["sort"], standard["traffic"]["sort"]);
  EXPECT_EQ(bench("--sorter cpu")["sorter"], "cpu");
  EXPECT_EQ(bench("--blend direct")["traffic"]["resolve"], 0);
  EXPECT_EQ(bench("--orbit-step 2")["views"], 3);
}

// Mesa's OSMesa cannot read a pixel while it draws.
TEST_F(BenchCommand, SlicesAreTheOnesThatWereDrawn) {
  EXPECT_EQ(bench("")["slices"], 1);
  EXPECT_EQ(bench("--slices 4")["slices"], 4);
  const Outcome without =
      fluxgs("bench " + quoted(scene_) +
             " --size 96x64 --frames 3 --warmup 1 --json --slices 4 --gl osmesa");
  ASSERT_EQ(without.status, 0) << without.err;
  EXPECT_EQ(json::parse(without.out)["slices"], 1);
  EXPECT_NE(without.err.find("--slices 4: this OpenGL"), std::string::npos) << without.err;
  const Outcome report = fluxgs("report render " + quoted(scene_) +
                                " --size 96x64 --views 1 --rounds 1 --only slices --json - "
                                "--gl osmesa");
  ASSERT_EQ(report.status, 0) << report.err;
  const json rows = json::parse(report.out)["settings"];
  EXPECT_FALSE(rows.empty());
  for (const json& row : rows) EXPECT_EQ(row["group"], "defaults");
  EXPECT_NE(report.err.find("16 slices' is left out"), std::string::npos) << report.err;
}

TEST_F(BenchCommand, ReportOfColorsBeyondAllDisplaysIsFinite) {
  SplatCloud cloud = test::random_cloud(200, 0, 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.sh_dc[i].x = i % 3 == 0 ? 3e38F : 1e12F;
  const auto scene = folder_ / "bright.ply";
  ASSERT_TRUE(write_scene(scene, cloud));
  const Outcome o = fluxgs("report render " + quoted(scene) +
                           " --size 96x64 --views 1 --rounds 1 --only defaults --json -");
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_TRUE(json::parse(o.out)["settings"][0]["ssim"].is_number()) << o.out;
  EXPECT_NE(o.err.find("67 of 200 splats are not drawn"), std::string::npos) << o.err;
}

TEST_F(BenchCommand, ReportComparesTheSettings) {
  const auto plot = folder_ / "plot.svg";
  const Outcome o = fluxgs("report render " + quoted(scene_) +
                           " --size 96x64 --views 2 --rounds 2 --json - --plot " + quoted(plot));
  ASSERT_EQ(o.status, 0) << o.err;
  const json r = json::parse(o.out);
  EXPECT_NE(test::text_of(plot).find("Pareto"), std::string::npos);
  double exact = 0, coarse = 0, front = 0;
  for (const json& row : r["settings"]) {
    EXPECT_GT(row["ms"].get<double>(), 0);
    EXPECT_GT(row["bytes_per_frame"].get<double>(), 0);
    if (row["group"] == "defaults") exact = row["psnr"].get<double>();
    if (row["name"] == "scale 0.5") coarse = row["psnr"].get<double>();
    front += row["on_front"].get<bool>();
  }
  EXPECT_GT(exact, 60);
  EXPECT_LT(coarse, exact);
  EXPECT_GE(front, 1);
}

TEST_F(BenchCommand, ReportsOnlyWhatIsAskedFor) {
  const Outcome o =
      fluxgs("report render " + quoted(scene_) +
             " --size 32x24 --views 2 --rounds 1 --only splat-precision,scale --json -");
  ASSERT_EQ(o.status, 0) << o.err;
  const json r = json::parse(o.out);
  std::vector<std::string> groups;
  for (const json& row : r["settings"]) {
    groups.push_back(row["group"]);
    EXPECT_LE(row["psnr_worst"].get<double>(), row["psnr"].get<double>());
  }
  EXPECT_EQ(groups, (std::vector<std::string>{"defaults", "defaults", "splat-precision", "scale",
                                              "scale", "scale"}));
  EXPECT_EQ(fluxgs("report render " + quoted(scene_) + " --only everything").status, 2);
}

TEST_F(BenchCommand, SaysWhatIsWrong) {
  expect_error(fluxgs("bench /nowhere.glb"), {"/nowhere.glb"});
  EXPECT_EQ(fluxgs("bench " + quoted(scene_) + " --frames 0").status, 2);
  EXPECT_EQ(fluxgs("bench " + quoted(scene_) + " --key-bits 9").status, 2);
  EXPECT_EQ(fluxgs("bench " + quoted(scene_) + " --sorter quick").status, 2);
  expect_error(fluxgs("bench " + quoted(scene_) + " --gl angle", "FLUXGS_ANGLE_DIR=/nowhere"),
               {"/nowhere"});
}

}  // namespace
}  // namespace fluxgs
