// Reading what Mesa's compiler for Adreno says, and comparing it with a baseline.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/adreno/baseline.h"

namespace fluxgs::adreno {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::string_view kRest =
    " 6 mov, 0 cov, 96 dwords, 0 last-baryf, 2 half, 3 full, 8 constlen, 39 cat0, 1 stp, 4 ldp, "
    "7 sstall, 1 (ss), 9 systall, 0 (sy), 16 waves, 0 loops, 16 preamble-inst\n";

std::string message(const std::string& stage, int instructions) {
  return "message: " + stage + " shader: " + std::to_string(instructions) +
         " inst, 34 nops, 19 non-nops," + std::string(kRest);
}

const std::string kHead =
    "driver: FD750\n"
    "version: OpenGL ES 3.1 Mesa 26.1.6-1~bpo13+1\n";

Expected<GpuStatistics> parse(const std::string& log) { return parse_statistics(log, "a750.log"); }

TEST(AdrenoStatistics, AreReadFromTheDriversLines) {
  const auto gpu = parse(kHead +
                         "program: sort\n"
                         "MESA: info: NIR (final form) for CL shader GLSL2:\n"
                         "MESA: info: shared_size: 5120\n" +
                         message("CL", 53) + "program: splat\nmessage: something else\n" +
                         message("VERT", 20) + message("BVERT", 10) + message("FRAG", 30));
  ASSERT_TRUE(gpu) << gpu.error().message();
  EXPECT_EQ(gpu->gpu, "a750");
  EXPECT_EQ(gpu->mesa, "26.1.6-1~bpo13+1");
  ASSERT_EQ(gpu->shaders.size(), 4U);
  const ShaderStatistics& sort = gpu->shaders[0];
  EXPECT_EQ(sort.program, "sort");
  EXPECT_EQ(sort.stage, "compute");
  EXPECT_EQ(sort.instructions, 53);
  EXPECT_EQ(sort.without_nops, 19);
  EXPECT_EQ(sort.half_registers, 2);
  EXPECT_EQ(sort.full_registers, 3);
  EXPECT_EQ(sort.waves, 16);
  EXPECT_EQ(sort.short_stalls, 7);
  EXPECT_EQ(sort.long_stalls, 9);
  EXPECT_EQ(sort.spills, 5);
  EXPECT_EQ(sort.shared_bytes, 5120);
  std::vector<std::string> stages;
  for (const ShaderStatistics& s : gpu->shaders) stages.push_back(s.program + " " + s.stage);
  EXPECT_THAT(stages,
              ElementsAre("sort compute", "splat vertex", "splat binning", "splat fragment"));
  EXPECT_EQ(gpu->shaders[3].shared_bytes, 0);
}

TEST(AdrenoStatistics, WhatIsMissingIsNamed) {
  const auto error = [](const std::string& log) {
    const auto gpu = parse(log);
    return gpu ? std::string("was read") : gpu.error().message();
  };
  EXPECT_THAT(error(""), HasSubstr("a750.log: driver: is not that of an Adreno"));
  EXPECT_THAT(error("driver: llvmpipe (LLVM 19)\nprogram: sort\n" + message("CL", 1)),
              HasSubstr("not that of an Adreno"));
  EXPECT_THAT(error(kHead), HasSubstr("there are none"));
  EXPECT_THAT(error(kHead + "program: sort\nprogram: splat\n"), HasSubstr("sort: has statistics"));
  EXPECT_THAT(error(kHead + "program: splat\n" + message("VERT", 1) + message("FRAG", 1)),
              HasSubstr("\"vertex binning fragment\" was expected"));
  EXPECT_THAT(error(kHead + "program: sort\nmessage: CL shader: 53 inst, 34 nops\n"),
              HasSubstr("no \"non-nops\""));
}

GpuStatistics example() {
  GpuStatistics gpu{"a750", "26.1.6-1~bpo13+1", {}};
  gpu.shaders.push_back({"sort", "compute", 100, 60, 0, 8, 16, 40, 200, 0, 1024});
  gpu.shaders.push_back({"splat", "fragment", 20, 10, 2, 3, 16, 0, 0, 0, 0});
  return gpu;
}

std::vector<std::string> worse(const GpuStatistics& now) {
  const GpuStatistics before = example();
  return regressions({&before, 1}, {&now, 1});
}

TEST(AdrenoBaseline, ComesBackFromItsFile) {
  GpuStatistics other = example();
  other.gpu = "a630";
  const std::vector<GpuStatistics> gpus = {example(), other};
  const std::string text = to_json(gpus);
  const auto read = from_json(text, "baseline.json");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(to_json(*read), text);
  EXPECT_THAT(regressions(*read, gpus), IsEmpty());
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[1].gpu, "a630");
  EXPECT_EQ((*read)[1].mesa, "26.1.6-1~bpo13+1");
  EXPECT_EQ((*read)[0].shaders[0].shared_bytes, 1024);
}

TEST(AdrenoBaseline, ABrokenFileIsNamed) {
  for (const char* text :
       {"", "[]", "{}", R"({"mesa":"1","gpus":{}})", R"({"mesa":"1","gpus":{"a750":1}})",
        R"({"mesa":"1","gpus":{"a750":{"sort":{}}}})",
        R"({"mesa":"1","gpus":{"a750":{"sort compute":{"instructions":"many"}}}})"}) {
    const auto read = from_json(text, "baseline.json");
    ASSERT_FALSE(read) << text;
    EXPECT_THAT(read.error().message(), HasSubstr("baseline.json")) << text;
  }
}

TEST(AdrenoBaseline, AFewPerCentAreForgivenMoreIsNot) {
  GpuStatistics now = example();
  now.shaders[0].instructions = 105;
  now.shaders[1].full_registers = 4;  // a third more, but only one
  now.shaders[0].long_stalls = 0;     // better
  EXPECT_THAT(worse(now), IsEmpty());
  now.shaders[0].instructions = 106;
  now.shaders[1].full_registers = 5;
  now.shaders[1].short_stalls = 2;
  EXPECT_THAT(worse(now), ElementsAre("sort compute on a750: instructions 106, baseline 100",
                                      "splat fragment on a750: full_registers 5, baseline 3",
                                      "splat fragment on a750: short_stalls 2, baseline 0"));
}

TEST(AdrenoBaseline, FewerWavesAndAnySpillAreWorse) {
  GpuStatistics now = example();
  now.shaders[0].waves = 15;
  now.shaders[1].spills = 1;
  EXPECT_THAT(worse(now), ElementsAre("sort compute on a750: waves 15, baseline 16",
                                      "splat fragment on a750: spills 1, baseline 0"));
}

TEST(AdrenoBaseline, ProgramsAndGpusBelongToBoth) {
  GpuStatistics now = example();
  now.shaders[0].program = "scan";
  EXPECT_THAT(worse(now), ElementsAre("scan compute on a750: not in the baseline",
                                      "sort compute on a750: only in the baseline"));
  now.gpu = "a740";
  EXPECT_THAT(worse(now), ElementsAre("a740: not in the baseline"));
}

TEST(AdrenoBaseline, IsOfOneReleaseOfMesa) {
  GpuStatistics other = example();
  other.mesa = "26.1.6-2";
  EXPECT_TRUE(same_compiler(example(), other));
  other.mesa = "26.1.7-1~bpo13+1";
  EXPECT_FALSE(same_compiler(example(), other));
}

}  // namespace
}  // namespace fluxgs::adreno
