// What a scene announces before it is decoded.
#include "fluxgs/io/scene_estimate.h"

#include <gtest/gtest.h>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/io/splat.h"
#include "fluxgs/io/spz.h"
#include "sog_support.h"
#include "support.h"

namespace fluxgs {
namespace {

TEST(SceneEstimate, IsWhatDecodingFinds) {
  for (const int degree : {0, 1, 2, 3}) {
    const SplatCloud cloud = test::random_cloud(1000, degree);
    for (const SceneFormat& format : scene_formats()) {
      if (format.encode == nullptr) continue;
      const auto bytes = *format.encode(cloud, "scene", {});
      const auto estimate = estimate_scene(bytes, "scene");
      ASSERT_TRUE(estimate) << format.name << ": " << estimate.error().message();
      const auto scene = *read_scene(bytes, "scene");
      EXPECT_EQ(estimate->format, scene.format);
      EXPECT_EQ(estimate->splats, scene.cloud.size()) << format.name;
      EXPECT_EQ(estimate->sh_degree, scene.cloud.sh_degree) << format.name;
      EXPECT_EQ(estimate->decoded, splat_memory_bytes(1000, scene.cloud.sh_degree));
    }
    const auto compact = *encode_compact_glb(cloud, {}, "scene");
    EXPECT_EQ(estimate_scene(compact, "scene")->splats, 1000U);
  }
}

TEST(SceneEstimate, OfAnArchiveOfImages) {
  for (const int degree : {0, 2}) {
    const SplatCloud cloud = test::random_cloud(300, degree);
    const auto bytes = test::bundle(test::make_sog(cloud));
    const auto estimate = estimate_scene(bytes, "scene.sog");
    ASSERT_TRUE(estimate) << estimate.error().message();
    EXPECT_EQ(estimate->format, "sog");
    EXPECT_EQ(estimate->splats, 300U);
    EXPECT_EQ(estimate->sh_degree, degree);
    EXPECT_EQ(estimate->decoded, splat_memory_bytes(300, degree));
  }
}

TEST(SceneEstimate, OfTheBeginningOfAFile) {
  const SplatCloud cloud = test::random_cloud(4000, 0, 1);
  for (const auto& [format, bytes] : {std::pair("ply", *encode_ply(cloud, "scene")),
                                      {"splat", *encode_splat(cloud, "scene")},
                                      {"spz", *encode_spz(cloud, "scene")}}) {
    const std::span begin = std::span(bytes).first(bytes.size() / 2 + 7);
    const auto estimate = estimate_beginning(begin, bytes.size(), "scene");
    ASSERT_TRUE(estimate) << format;
    EXPECT_EQ(estimate->format, format);
    EXPECT_EQ(estimate->splats, 4000U);
  }
  const auto splat = *encode_splat(cloud, "scene");
  EXPECT_FALSE(estimate_beginning(splat, kUnknownSize, "scene")) << "nobody knows how many";
}

TEST(SceneEstimate, RefusesWhatIsNoScene) {
  EXPECT_FALSE(estimate_scene({}, "empty"));
  EXPECT_FALSE(estimate_scene(test::bytes_of("just some text"), "text"));
  EXPECT_FALSE(estimate_scene(test::bytes_of("ply\nformat ascii 1.0\n"), "cut"));
}

TEST(SceneEstimate, OfRealScenes) {
  for (const char* file :
       {"plush-dog/converted/plush-dog.glb", "plush-dog/converted/plush-dog.v3.spz",
        "plush-dog/converted/plush-dog.v4.spz", "plush-dog/converted/plush-dog.splat",
        "plush-dog/point_cloud_29999_clean.ply", "plush-dog/point_cloud_29999_clean.compressed.ply",
        "biker/biker.spz"}) {
    const auto path = test::data_file(std::string("splats/") + file);
    if (!path || !std::filesystem::exists(*path)) continue;
    const auto bytes = *read_file(*path);
    const auto scene = *read_scene(bytes, file);
    EXPECT_EQ(estimate_scene(bytes, file)->splats, scene.cloud.size() + scene.dropped);
  }
}

}  // namespace
}  // namespace fluxgs
