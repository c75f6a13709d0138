// SOG scenes that are as they should be: bundled, in a folder, streamed, version 1, real ones.
#include "fluxgs/io/scene.h"
#include "sog_support.h"

namespace fluxgs {
namespace {

using namespace test;

double angle_between(glm::quat a, glm::quat b) {
  const glm::dquat p = glm::normalize(glm::dquat(a)), q = glm::normalize(glm::dquat(b));
  return 2 * std::acos(std::min(1.0, std::abs(glm::dot(p, q))));
}

double opacity_of(float logit) { return 1 / (1 + std::exp(-double{logit})); }

// Half a step h of each attribute. Of a rotation three components are off by h, and the fourth,
// which is at least one half, by up to √3·√3·h: a chord of √12·h, and twice that as an angle.
TEST(Sog, RoundTripIsWithinHalfAStep) {
  for (int degree = 0; degree <= 3; ++degree) {
    const SplatCloud cloud = random_cloud(500, degree, 7);
    FLUXGS_UNWRAP(scene, read_bundle(make_sog(cloud)));
    ASSERT_EQ(scene.cloud.size(), cloud.size());
    EXPECT_EQ(scene.cloud.sh_degree, degree);
    EXPECT_EQ(scene.dropped, 0u);
    double position = 0, scale = 0, opacity = 0, dc = 0, rest = 0, angle = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        position = std::max(position, std::abs(symmetric_log(scene.cloud.positions[i][c]) -
                                               symmetric_log(cloud.positions[i][c])));
        scale = std::max<double>(scale,
                                 std::abs(scene.cloud.log_scales[i][c] - cloud.log_scales[i][c]));
        dc = std::max<double>(dc, std::abs(scene.cloud.sh_dc[i][c] - cloud.sh_dc[i][c]));
      }
      opacity = std::max(opacity, std::abs(opacity_of(scene.cloud.opacity_logits[i]) -
                                           opacity_of(cloud.opacity_logits[i])));
      angle = std::max(angle, angle_between(scene.cloud.rotations[i], cloud.rotations[i]));
    }
    for (std::size_t k = 0; k < cloud.sh_rest.size(); ++k) {
      for (int c = 0; c < 3; ++c)
        rest = std::max<double>(rest, std::abs(scene.cloud.sh_rest[k][c] - cloud.sh_rest[k][c]));
    }
    const double tiny = 1e-6, component = 1 / 255.0 / std::sqrt(2.0);
    EXPECT_LE(position, 2 * std::log(2.0) / 65535 / 2 + tiny);
    EXPECT_LE(scale, steps_of(cloud.log_scales).half_step() + tiny);
    EXPECT_LE(dc, steps_of(cloud.sh_dc).half_step() + tiny);
    EXPECT_LE(opacity, 0.5 / 255 + tiny);
    EXPECT_LE(angle, 2 * component * std::sqrt(12.0));
    if (degree > 0) {
      EXPECT_LE(rest, steps_of(cloud.sh_rest).half_step() + tiny);
    }
    for (const auto& [name, value] :
         {std::pair("position", position), std::pair("scale", scale), std::pair("dc", dc),
          std::pair("opacity", opacity), std::pair("angle", angle), std::pair("rest", rest)}) {
      RecordProperty(fmt::format("degree{}_{}", degree, name), fmt::format("{:.3g}", value));
    }
  }
}

// One splat, every number solvable by hand.
Files by_hand() {
  Files files;
  json codebook = json::array(), colours = json::array(), coefficients = json::array();
  for (int i = 0; i < 256; ++i) {
    codebook.push_back(-i);
    colours.push_back(i / 4.0);
    coefficients.push_back(i - 128);
  }
  set_meta(
      files,
      {{"version", 2},
       {"count", 1},
       {"means",
        {{"mins", {0, -std::log(3.0), 0}},
         {"maxs", {std::log(2.0), 0, 65535e-4}},
         {"files", {"a", "b"}}}},
       {"scales", {{"codebook", codebook}, {"files", {"c"}}}},
       {"quats", {{"files", {"d"}}}},
       {"sh0", {{"codebook", colours}, {"files", {"e"}}}},
       {"shN", {{"count", 66}, {"bands", 1}, {"codebook", coefficients}, {"files", {"f", "g"}}}}});
  files["a"] = webp({{255, 0, 0x34, 255}});  // low bytes
  files["b"] = webp({{255, 0, 0x12, 255}});
  files["c"] = webp({{1, 2, 250, 255}});
  files["d"] = webp({{255, 255, 0, 254}});  // the largest is y
  files["e"] = webp({{0, 4, 255, 51}});
  std::vector<Pixel> palette(192 * 2);
  palette[192 + 3] = {129, 130, 131, 255};  // entry 65: second row, second of it
  palette[192 + 4] = {0, 128, 255, 255};
  palette[192 + 5] = {128, 128, 127, 255};
  files["f"] = webp(palette, 192, 2);
  files["g"] = webp({{65, 0, 0, 255}});
  return files;
}

TEST(Sog, KnownValues) {
  FLUXGS_UNWRAP(scene, read_bundle(by_hand()));
  const SplatCloud& cloud = scene.cloud;
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_NEAR(cloud.positions[0].x, 1, 1e-6);  // e^ln2 − 1
  EXPECT_NEAR(cloud.positions[0].y, -2, 1e-6);
  EXPECT_NEAR(cloud.positions[0].z, std::exp(0x1234 * 1e-4) - 1, 1e-6);
  EXPECT_EQ(cloud.log_scales[0], glm::vec3(-1, -2, -250));
  EXPECT_EQ(cloud.sh_dc[0], glm::vec3(0, 1, 63.75f));
  EXPECT_NEAR(cloud.opacity_logits[0], std::log(0.25), 1e-6);  // opacity 51/255
  const float root = std::sqrt(0.5f);
  EXPECT_NEAR(cloud.rotations[0].w, root, 1e-6);
  EXPECT_NEAR(cloud.rotations[0].x, root, 1e-6);
  EXPECT_NEAR(cloud.rotations[0].y, 0, 1e-6);  // nothing is left for the largest
  EXPECT_NEAR(cloud.rotations[0].z, -root, 1e-6);
  ASSERT_EQ(cloud.sh_degree, 1);
  EXPECT_EQ(cloud.sh_rest[0], glm::vec3(1, 2, 3));
  EXPECT_EQ(cloud.sh_rest[1], glm::vec3(-128, 0, 127));
  EXPECT_EQ(cloud.sh_rest[2], glm::vec3(0, 0, -1));
}

TEST(Sog, EveryModeNamesTheOmittedComponent) {
  for (std::uint8_t mode = 0; mode < 4; ++mode) {
    Files files = by_hand();
    files["d"] = webp({{191, 128, 64, static_cast<std::uint8_t>(252 + mode)}});
    FLUXGS_UNWRAP(scene, read_bundle(files));
    const glm::quat& q = scene.cloud.rotations[0];
    std::vector<float> wxyz{q.w, q.x, q.y, q.z};
    EXPECT_NEAR(wxyz[mode], std::sqrt(1 - (0.248 + 0.248) / 2), 0.001) << int(mode);
    wxyz.erase(wxyz.begin() + mode);
    EXPECT_NEAR(wxyz[0], 127.0 / 255 / std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(wxyz[1], 1.0 / 255 / std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(wxyz[2], -127.0 / 255 / std::sqrt(2.0), 1e-6);
  }
}

TEST(Sog, OpacitiesOfZeroAndOneAreFinite) {
  for (const auto& [byte, logit] : {std::pair(0, -87.3365), std::pair(255, 17.3287)}) {
    Files files = by_hand();
    files["e"] = webp({{0, 0, 0, static_cast<std::uint8_t>(byte)}});
    FLUXGS_UNWRAP(scene, read_bundle(files));
    ASSERT_EQ(scene.cloud.size(), 1u);
    EXPECT_NEAR(scene.cloud.opacity_logits[0], logit, 1e-3);
  }
}

TEST(Sog, VersionOneHasRangesInsteadOfCodebooks) {
  Files files = by_hand();
  json meta = meta_of(files);
  meta.erase("version");
  meta.erase("count");
  meta["means"]["shape"] = {1, 3};
  meta["scales"] = {{"mins", {0, 0, -255}}, {"maxs", {255, 510, 0}}, {"files", {"c"}}};
  meta["sh0"] = {{"mins", {5, 0, 0, -51}}, {"maxs", {5, 255, -255, 204}}, {"files", {"e"}}};
  meta["shN"] = {{"mins", -128}, {"maxs", 127}, {"files", {"f", "g"}}};
  set_meta(files, meta);
  FLUXGS_UNWRAP(scene, read_bundle(files));
  const SplatCloud& cloud = scene.cloud;
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_NEAR(cloud.positions[0].y, -2, 1e-6);
  EXPECT_EQ(cloud.log_scales[0], glm::vec3(1, 4, -5));
  EXPECT_EQ(cloud.sh_dc[0], glm::vec3(5, 4, -255));
  EXPECT_EQ(cloud.opacity_logits[0], 0);  // a logit, not an opacity
  ASSERT_EQ(cloud.sh_degree, 1);
  EXPECT_EQ(cloud.sh_rest[0], glm::vec3(1, 2, 3));
}

TEST(Sog, DegreeAndCountOfAPaletteMayBeLeftToItsImage) {
  Files files = by_hand();
  json meta = meta_of(files);
  meta["shN"].erase("bands");
  meta["shN"].erase("count");
  set_meta(files, meta);
  FLUXGS_UNWRAP(scene, read_bundle(files));
  EXPECT_EQ(scene.cloud.sh_degree, 1);
  meta["shN"]["bands"] = 0;
  set_meta(files, meta);
  FLUXGS_UNWRAP(flat, read_bundle(files));
  EXPECT_EQ(flat.cloud.sh_degree, 0);
}

TEST(Sog, CodebookWithoutItsFirstNumberIsContinued) {
  Files files = by_hand();
  json meta = meta_of(files);
  meta["scales"]["codebook"][0] = nullptr;  // its mean step is −254/255
  set_meta(files, meta);
  files["c"] = webp({{0, 1, 2, 255}});
  FLUXGS_UNWRAP(scene, read_bundle(files));
  EXPECT_NEAR(scene.cloud.log_scales[0].x, -1 + 254.0 / 255, 1e-6);
  EXPECT_EQ(scene.cloud.log_scales[0].y, -1);
}

TEST(Sog, SplatsBeyondFloatAreDroppedAndCounted) {
  Files files = make_sog(random_cloud(20, 0));
  json meta = meta_of(files);
  meta["means"]["maxs"][1] = 1000;  // e^1000
  set_meta(files, meta);
  FLUXGS_UNWRAP(scene, read_bundle(files));
  EXPECT_GT(scene.dropped, 0u);
  EXPECT_EQ(scene.cloud.size() + scene.dropped, 20u);
}

TEST(SogFolder, IsTheSameSceneAsItsBundle) {
  const Files files = make_sog(random_cloud(40, 2));
  const TemporaryFolder folder;
  write_files(folder, files);
  FLUXGS_UNWRAP(scene, read_scene(folder / "meta.json"));
  FLUXGS_UNWRAP(bundled, read_bundle(files));
  EXPECT_EQ(scene.format, "sog-folder");
  EXPECT_EQ(bundled.format, "sog");
  EXPECT_EQ(scene.cloud.positions, bundled.cloud.positions);
  EXPECT_EQ(scene.cloud.rotations, bundled.cloud.rotations);
  EXPECT_EQ(scene.cloud.sh_rest, bundled.cloud.sh_rest);
  std::size_t bytes = 0;
  for (const auto& [name, content] : files) bytes += content.size();
  EXPECT_EQ(scene.bytes, bytes);
  // Found by its content, whatever its name; in the current folder, too.
  std::filesystem::rename(folder / "meta.json", folder / "scene");
  EXPECT_TRUE(read_scene(folder / "scene"));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const auto here = read_scene("scene");
  std::filesystem::current_path(before);
  EXPECT_TRUE(here);
}

json leaf(int file, std::size_t offset, std::size_t count) {
  return {{"lods",
           {{"0", {{"file", file}, {"offset", offset}, {"count", count}}},
            {"1", {{"file", 2}, {"offset", 0}, {"count", 5}}}}}};
}

json lod_meta() {
  return {
      {"lodLevels", 2},
      {"environment", nullptr},
      {"filenames", {"0_1/meta.json", "0_0/meta.json", "1_0/missing.json"}},
      {"tree", {{"children", {leaf(1, 0, 10), {{"children", {leaf(1, 10, 5), leaf(0, 0, 7)}}}}}}}};
}

TEST(SogLod, LevelZeroIsOneCloudInTheOrderOfItsFiles) {
  const TemporaryFolder folder;
  const Files first = make_sog(random_cloud(7, 1, 1)), second = make_sog(random_cloud(15, 2, 2));
  write_files(folder, first, "0_1/");
  write_files(folder, second, "0_0/");
  write_files(folder, {{"lod-meta.json", bytes_of(lod_meta().dump())}});
  FLUXGS_UNWRAP(scene, read_scene(folder / "lod-meta.json"));
  FLUXGS_UNWRAP(a, read_bundle(first));
  FLUXGS_UNWRAP(b, read_bundle(second));
  EXPECT_EQ(scene.format, "sog-lod");
  ASSERT_EQ(scene.cloud.size(), 22u);
  ASSERT_EQ(scene.cloud.sh_degree, 2);
  EXPECT_EQ(scene.cloud.positions[6], a.cloud.positions[6]);
  EXPECT_EQ(scene.cloud.positions[7], b.cloud.positions[0]);
  EXPECT_EQ(scene.cloud.sh_rest[6 * 8 + 2], a.cloud.sh_rest[6 * 3 + 2]);
  EXPECT_EQ(scene.cloud.sh_rest[6 * 8 + 3], glm::vec3(0));  // a degree that the first lacks
  EXPECT_EQ(scene.cloud.sh_rest[21 * 8 + 7], b.cloud.sh_rest[14 * 8 + 7]);
  EXPECT_GT(scene.bytes, 1000u);
}

TEST(SogFormats, AreFoundByContentAndFoldersAreNotWritten) {
  const Files files = make_sog(random_cloud(3, 0));
  FLUXGS_UNWRAP(scene, read_scene(bundle(files), "x"));
  EXPECT_EQ(scene.format, "sog");
  expect_error(read_scene(files.at("meta.json"), "x.json"), {"x.json", "path"});
  expect_error(read_scene(bytes_of(lod_meta().dump()), "x.json"), {"x.json", "path"});
  expect_error(scene_format_for("meta.json"), {"meta.json", "not written", ".ply, .glb"});
  expect_error(write_scene("meta.json", random_cloud(1, 0)), {"meta.json", "not written"});
  EXPECT_FALSE(is_sog(bytes_of("PK\x03\x04")));
  EXPECT_FALSE(is_sog(zip_of({stored("readme.txt", bytes_of("hello"))})));
  EXPECT_FALSE(is_sog_meta(bytes_of("{\"meshes\": []}")));
  EXPECT_FALSE(is_sog_lod({}));
}

TEST(SogRealFiles, BundledAngel) {
  const auto path = data_file("splats/angel-sog/angel.sog");
  if (!path) GTEST_SKIP() << "FLUXGS_DATA names no folder with splats/angel-sog";
  FLUXGS_UNWRAP(scene, read_scene(*path));
  EXPECT_EQ(scene.format, "sog");
  EXPECT_EQ(scene.cloud.size(), 71359u);
  EXPECT_EQ(scene.cloud.sh_degree, 0);
  EXPECT_EQ(scene.dropped, 0u);
  EXPECT_EQ(scene.bytes, std::filesystem::file_size(*path));
}

TEST(SogRealFiles, StreamedPlaybotAndItsFinestChunk) {
  const auto path = data_file("splats/playbot-sog-lod/lod-meta.json");
  if (!path) GTEST_SKIP() << "FLUXGS_DATA names no folder with splats/playbot-sog-lod";
  FLUXGS_UNWRAP(scene, read_scene(*path));
  EXPECT_EQ(scene.cloud.size(), 500000u);
  EXPECT_EQ(scene.cloud.sh_degree, 2);
  EXPECT_EQ(scene.dropped, 0u);
  FLUXGS_UNWRAP(chunk, read_scene(path->parent_path() / "0_0/meta.json"));
  EXPECT_EQ(chunk.cloud.positions, scene.cloud.positions);
  EXPECT_EQ(chunk.cloud.sh_rest, scene.cloud.sh_rest);
  // The box that the tree states holds the splats with their extents.
  for (const glm::vec3& p : scene.cloud.positions) {
    ASSERT_TRUE(p.x > -1.04f && p.x < 1.04f && p.y > -1.09f && p.y < 0.06f && p.z > -1.04f &&
                p.z < 1.05f);
  }
}

// A folder packed as a whole, by Finder, Explorer, and programs that write backslashes.
TEST(Sog, ScenesInAFolderOfTheArchiveAreRead) {
  const Files files = make_sog(random_cloud(5, 1));
  FLUXGS_UNWRAP(plain, read_bundle(files));
  for (const std::string folder : {"scene/", "a/b/c/", "My scene (1)/", "scene\\"}) {
    SCOPED_TRACE(folder);
    std::vector<ZipEntry> entries;
    if (folder.ends_with('/')) entries.push_back(stored(folder, {}));
    entries.push_back(stored(folder + ".DS_Store", bytes_of("Bud1")));
    for (const auto& [name, bytes] : files) entries.push_back(stored(folder + name, bytes));
    for (const auto& [name, bytes] : files)
      entries.push_back(stored("__MACOSX/" + folder + "._" + name, bytes_of("Mac OS X")));
    entries.push_back(stored("__MACOSX/meta.json", bytes_of("Mac OS X")));
    for (const Bytes& zip : {zip_of(entries), in_zip64(zip_of(entries))}) {
      EXPECT_TRUE(is_sog(zip));
      FLUXGS_UNWRAP(scene, read_scene(zip, "x.sog"));
      EXPECT_EQ(scene.format, "sog");
      EXPECT_EQ(scene.cloud.positions, plain.cloud.positions);
      EXPECT_EQ(scene.cloud.sh_rest, plain.cloud.sh_rest);
    }
  }
}

TEST(Sog, SeveralScenesInOneArchiveAreRefused) {
  std::vector<ZipEntry> entries;
  for (const char* folder : {"a/", "b/"})
    for (const auto& [name, bytes] : make_sog(random_cloud(2, 0)))
      entries.push_back(stored(folder + name, bytes));
  expect_error(read_sog(zip_of(entries), "x.sog"), {"b/meta.json", "second scene beside a/meta"});
  // The one above the others is the one that is meant.
  for (const auto& [name, bytes] : make_sog(random_cloud(3, 0)))
    entries.push_back(stored(name, bytes));
  FLUXGS_UNWRAP(scene, read_sog(zip_of(entries), "x.sog"));
  EXPECT_EQ(scene.cloud.size(), 3U);
  entries.push_back(stored("lod-meta.json", bytes_of("{}")));
  expect_error(read_sog(zip_of(entries), "x.sog"), {"second scene beside"});
}

TEST(SogLod, IsReadFromAnArchiveToo) {
  const Files first = make_sog(random_cloud(7, 1, 1)), second = make_sog(random_cloud(15, 2, 2));
  const TemporaryFolder folder;
  write_files(folder, first, "0_1/");
  write_files(folder, second, "0_0/");
  write_files(folder, {{"lod-meta.json", bytes_of(lod_meta().dump())}});
  FLUXGS_UNWRAP(unpacked, read_scene(folder / "lod-meta.json"));
  const auto packed = [&](const std::string& where, const json& lod) {
    std::vector<ZipEntry> entries = {stored(where + "lod-meta.json", bytes_of(lod.dump()))};
    for (const auto& [name, bytes] : first) entries.push_back(stored(where + "0_1/" + name, bytes));
    for (const auto& [name, bytes] : second)
      entries.push_back(stored(where + "0_0/" + name, bytes));
    return zip_of(entries);
  };
  for (const char* where : {"", "scene/"}) {
    FLUXGS_UNWRAP(scene, read_scene(packed(where, lod_meta()), "x.zip"));
    EXPECT_EQ(scene.cloud.positions, unpacked.cloud.positions);
    EXPECT_EQ(scene.cloud.sh_rest, unpacked.cloud.sh_rest);
    EXPECT_EQ(scene.attribute_bits, unpacked.attribute_bits);
  }
  FLUXGS_UNWRAP(announced, announced_by_sog(packed("", lod_meta()), "x.zip"));
  EXPECT_EQ(announced, std::pair(std::size_t{22}, 2));
  // However many names the tree has for a file, it is read once
  json twice = lod_meta();
  twice["filenames"] = {"0_0/meta.json", "0_0/meta.json", "0_0/meta.json"};
  twice["tree"] = {{"children", {leaf(0, 0, 15), leaf(1, 0, 15)}}};
  expect_error(read_scene(packed("", twice), "x.zip"), {"0_0/meta.json", "named twice"});
}

TEST(Sog, TheFilterIsRead) {
  const auto filter_with = [](const char* key, const json& value) {
    Files files = make_sog(random_cloud(2, 0));
    json meta = meta_of(files);
    meta[key] = value;
    set_meta(files, meta);
    const auto scene = read_bundle(files);
    EXPECT_TRUE(scene) << key;
    return scene ? scene->cloud.filter : ScreenFilter{};
  };
  EXPECT_TRUE(filter_with("antialias", true).compensated);
  EXPECT_FALSE(filter_with("antialias", false).compensated);
  EXPECT_FALSE(filter_with("antialias", "yes").compensated);
  EXPECT_TRUE(filter_with("model", "antialiased").compensated);
  EXPECT_FALSE(filter_with("model", "2dgs").compensated);
  EXPECT_EQ(filter_with("dilation", 0.1).dilation, 0.1);
  EXPECT_EQ(filter_with("dilation", -1), ScreenFilter{});
}

}  // namespace
}  // namespace fluxgs
