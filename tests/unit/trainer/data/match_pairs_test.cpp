// Choosing the pairs of photos that are compared.
#include <algorithm>
#include <set>

#include "test_files.h"
#include "tools/capture/capture.h"
#include "trainer/data/photos/match_pairs.h"

namespace fluxgs {
namespace {

using namespace test;
using Pair = std::pair<int, int>;

std::vector<PreparedPhoto> photos(int count) {
  std::vector<PreparedPhoto> all(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) all[static_cast<std::size_t>(i)].copy = fmt::format("{:04}", i);
  return all;
}

TEST(MatchPairs, FewAreAllCompared) {
  EXPECT_TRUE(match_pairs(photos(1), "/nowhere", {}).empty());
  const auto pairs = match_pairs(photos(40), "/nowhere", {});
  EXPECT_EQ(pairs.size(), 40u * 39u / 2u);
  EXPECT_EQ(pairs.front(), Pair(0, 1)) << "neighbours first";
  EXPECT_EQ(pairs.back(), Pair(0, 39));
}

TEST(MatchPairs, GrowWithTheNumberOfPhotos) {
  const auto pairs = match_pairs(photos(4000), "/nowhere", {});
  EXPECT_LE(pairs.size(), 8u * 4000u);
  EXPECT_GE(pairs.size(), 7u * 4000u);
  EXPECT_TRUE(std::ranges::all_of(pairs, [](const Pair& p) { return p.first < p.second; }));
  EXPECT_EQ(std::set<Pair>(pairs.begin(), pairs.end()).size(), pairs.size());
}

TEST(MatchPairs, PhotosNearEachOtherByGps) {
  auto all = photos(200);  // two rounds of the same way
  for (std::size_t i = 0; i < all.size(); ++i)
    if (i != 50) all[i].position = glm::dvec3(48 + 1e-4 * static_cast<double>(i % 100), 11, 500);
  const auto list = match_pairs(all, "/nowhere", {});
  const std::set<Pair> pairs(list.begin(), list.end());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(pairs.contains(Pair(i, i + 100)), i != 50) << i;
}

TEST(MatchPairs, PhotosThatLookAlike) {
  const TempFolder folder;
  const capture::CaptureOptions options{
      .width = 160, .height = 120, .train = 24, .test = 1, .samples = 1};
  const auto cameras = capture::capture_cameras(options).train;
  const auto scene = capture::make_scene(1);
  auto all = photos(48);  // the second half shows the same views from behind to front
  for (int i = 0; i < 24; ++i) {
    const auto image = capture::render_view(scene, cameras[static_cast<std::size_t>(i)], 1);
    for (const int place : {i, 47 - i}) {
      auto& copy = all[static_cast<std::size_t>(place)].copy;
      copy += ".png";
      write_image(folder.path() / copy, image);
    }
  }
  std::vector<std::string> steps;
  const auto list = match_pairs(all, folder.path(),
                                [&](const std::string& step, const std::string&, std::size_t,
                                    std::size_t) { steps.push_back(step); });
  EXPECT_EQ(steps.size(), 48u);
  EXPECT_LE(list.size(), 20u * 48u);
  const std::set<Pair> pairs(list.begin(), list.end());
  for (int i = 0; i < 24; ++i) EXPECT_TRUE(pairs.contains(Pair(i, 47 - i))) << i;
  EXPECT_EQ(match_pairs(all, folder.path(), {}), list) << "the same every time";
}

}  // namespace
}  // namespace fluxgs
