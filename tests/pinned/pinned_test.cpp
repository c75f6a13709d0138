// Trainings give the bytes that they gave before: a change of structure that changes a result shows
// here. hashes.txt holds the hash of every scene; FLUXGS_UPDATE_PINS=1 writes it anew, and the
// commit that does so says why results changed.
#include <gtest/gtest.h>

#include <gnu/libc-version.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core/version.hpp>

#include "fluxgs/hash.h"
#include "fluxgs/io/file.h"
#include "support/temp_folder.h"
#include "tools/capture/capture.h"
#include "trainer/core/isa.h"

namespace fluxgs {
namespace {

constexpr const char* kHashes = FLUXGS_PINNED_FOLDER "/hashes.txt";

struct Case {
  const char* name;
  const char* options;
};

/// All 300 iterations long; intervals are shortened so that every part of the method takes place.
constexpr Case kCases[] = {
    {"flux", "--preset flux --densify-from 50 --sh-max-psnr-drop 0.1"},
    {"flux-paper",
     "--preset flux-paper --densify-from 50 --densify-interval 50 --opacity-reset-interval 100"},
    {"3dgs", "--preset 3dgs --densify-from 50 --densify-interval 50 --opacity-reset-interval 100"},
    {"3dgs-sh1",
     "--preset 3dgs-sh1 --densify-from 50 --densify-interval 50 --opacity-reset-interval 100"},
    {"densify-gradient", "--preset flux --densify-from 50 --densify gradient"},
    {"densify-multiview",
     "--preset 3dgs --densify-from 50 --densify-interval 50 --densify multiview --prune multiview "
     "--late-prune opacity"},
    {"densify-mcmc",
     "--preset 3dgs --densify-from 50 --densify-interval 50 --densify mcmc --opacity-weight 0.01 "
     "--scale-weight 0.01"},
};

/// Results depend on what these compute as well.
std::string surroundings() {
  return fmt::format("compiler {}, C library {}, OpenCV {}", __VERSION__, gnu_get_libc_version(),
                     CV_VERSION);
}

bool updates() { return std::getenv("FLUXGS_UPDATE_PINS") != nullptr; }

/// "CASE PRODUCTS FILE" to a hash; under "" what they were made with.
std::map<std::string, std::string> read_hashes() {
  std::map<std::string, std::string> hashes;
  std::ifstream in(kHashes);
  std::string line;
  if (std::getline(in, line)) hashes[""] = line;
  while (std::getline(in, line))
    if (const auto at = line.rfind(' '); at != std::string::npos)
      hashes[line.substr(0, at)] = line.substr(at + 1);
  return hashes;
}

void write_hashes(const std::map<std::string, std::string>& hashes) {
  std::ofstream out(kHashes);
  out << surroundings() << '\n';
  for (const auto& [key, hash] : hashes)
    if (!key.empty()) out << key << ' ' << hash << '\n';
}

const std::filesystem::path& capture_folder() {
  static const test::TempFolder folder;
  static const bool made = [] {
    capture::CaptureOptions options;
    options.width = 72, options.height = 54, options.train = 18, options.test = 2,
    options.samples = 2;
    return capture::write_capture(folder.path(), options).has_value();
  }();
  if (!made) throw std::runtime_error("cannot make a capture");
  return folder.path();
}

std::string hash_of(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  return bytes ? fmt::format("{:016x}", fnv1a(*bytes)) : bytes.error().message();
}

/// Kernels with fused products give the same bits, whatever their lanes.
std::string_view kernels_of(Isa isa) { return isa == Isa::baseline ? "separate" : "fused"; }

bool same_surroundings(const std::map<std::string, std::string>& hashes) {
  const auto found = hashes.find("");
  return updates() || (found != hashes.end() && found->second == surroundings());
}

/// Trains into scene.glb and scene.ply of a folder.
void train(const std::filesystem::path& capture, const std::filesystem::path& folder, Isa isa,
           const std::string& options) {
  const std::string command =
      fmt::format("FLUXGS_ISA={} '{}' train '{}' -o '{}' --float-output '{}' {} >'{}' 2>&1",
                  name_of(isa), FLUXGS_BINARY, capture.string(), (folder / "scene.glb").string(),
                  (folder / "scene.ply").string(), options, (folder / "log").string());
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

void expect_pinned(std::map<std::string, std::string>& hashes, const std::string& key,
                   const std::filesystem::path& file, bool may_be_missing = false) {
  const std::string hash = hash_of(file);
  if (updates())
    hashes[key] = hash;
  else if (const auto found = hashes.find(key); found != hashes.end())
    EXPECT_EQ(hash, found->second) << key;
  else
    EXPECT_TRUE(may_be_missing) << "no hash of " << key;
}

class Pinned : public testing::TestWithParam<std::tuple<Case, Isa>> {};

TEST_P(Pinned, TrainsTheSameScene) {
  const auto& [pinned, isa] = GetParam();
  auto hashes = read_hashes();
  if (!same_surroundings(hashes))
    GTEST_SKIP() << "pinned with " << hashes[""] << "; this is " << surroundings();
  const test::TempFolder folder;
  ASSERT_NO_FATAL_FAILURE(
      train(capture_folder(), folder.path(), isa,
            fmt::format("--iterations 300 --initial-splats 4000 {}", pinned.options)));
  for (const char* file : {"scene.ply", "scene.glb"}) {
    // onnxruntime decides what goes into this file, by sums whose order depends on the processor
    const bool networks = std::string(pinned.name) == "flux-paper" && file[6] == 'g';
    const std::string key =
        fmt::format("{} {} {}{}", pinned.name, kernels_of(isa), file,
                    networks ? fmt::format(" on {}", name_of(available_isas().back())) : "");
    expect_pinned(hashes, key, folder / file, networks);
  }
  if (updates()) write_hashes(hashes);
}

INSTANTIATE_TEST_SUITE_P(Trainings, Pinned,
                         testing::Combine(testing::ValuesIn(kCases),
                                          testing::ValuesIn(available_isas())),
                         [](const auto& pinned) {
                           std::string name = std::get<0>(pinned.param).name;
                           std::ranges::replace(name, '-', '_');
                           return name + "_" + std::string(name_of(std::get<1>(pinned.param)));
                         });

class QuickstartScene : public testing::TestWithParam<Isa> {};

/// The training of tools/quickstart at its whole length: README's numbers are of this file.
TEST_P(QuickstartScene, IsTheSame) {
  auto hashes = read_hashes();
  if (!same_surroundings(hashes))
    GTEST_SKIP() << "pinned with " << hashes[""] << "; this is " << surroundings();
  const test::TempFolder capture, folder;
  capture::CaptureOptions options;
  options.width = 320, options.height = 240, options.train = 40, options.test = 8;
  ASSERT_TRUE(capture::write_capture(capture.path(), options));
  ASSERT_NO_FATAL_FAILURE(train(capture.path(), folder.path(), GetParam(), "--iterations 3000"));
  expect_pinned(hashes, fmt::format("quickstart {} scene.glb", kernels_of(GetParam())),
                folder / "scene.glb");
  if (updates()) write_hashes(hashes);
}

std::vector<Isa> isas_with_fused_products() {
  std::vector<Isa> isas = available_isas();
  std::erase(isas, Isa::baseline);
  return isas;
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(QuickstartScene);
INSTANTIATE_TEST_SUITE_P(Fused, QuickstartScene, testing::ValuesIn(isas_with_fused_products()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

}  // namespace
}  // namespace fluxgs
