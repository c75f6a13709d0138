// SOG scenes from strangers: whatever the bytes are, a scene or one line that names the fault.
#include <sys/stat.h>
#include <zip.h>

#include <functional>
#include <random>

#include "fluxgs/io/scene.h"
#include "fluxgs/io/scene_estimate.h"
#include "sog_support.h"

namespace fluxgs {
namespace {

using namespace test;

Files small_sog() { return make_sog(random_cloud(5, 1)); }

// `text` in place of the first `from` in meta.json: for what no JSON library writes.
Files with_text(const std::string& from, const std::string& text) {
  Files files = small_sog();
  std::string meta = text_of(files["meta.json"]);
  const std::size_t at = meta.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  files["meta.json"] = bytes_of(meta.replace(at, from.size(), text));
  return files;
}

Files with_meta(const std::function<void(json&)>& change) {
  Files files = small_sog();
  json meta = meta_of(files);
  change(meta);
  set_meta(files, meta);
  return files;
}

TEST(SogHostile, CutArchivesAreErrors) {
  const Bytes whole = bundle(small_sog());
  ASSERT_TRUE(read_sog(whole, "whole.sog"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    const auto scene = read_sog(cut, "cut.sog");
    ASSERT_FALSE(scene) << size;
    EXPECT_EQ(scene.error().file, "cut.sog");
  }
}

TEST(SogHostile, CutImagesAndTextsAreErrors) {
  const Files whole = small_sog();
  for (const auto& [name, bytes] : whole) {
    const std::size_t step = std::max<std::size_t>(1, bytes.size() / 200);
    for (std::size_t size = 0; size + 2 < bytes.size(); size += step) {
      Files files = whole;
      files[name].resize(size);
      const auto scene = read_bundle(files);
      ASSERT_FALSE(scene) << name << ' ' << size;
      EXPECT_EQ(scene.error().file, "test.sog");
    }
  }
}

TEST(SogHostile, RandomDamageIsASceneOrAnError) {
  const Files whole = small_sog();
  const Bytes zip = bundle(whole);
  std::mt19937 random(3);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = zip;
    if (round % 2 == 0) {  // an image, with its CRC mended so that the decoder sees it
      Files files = whole;
      auto file = files.begin();
      std::advance(file, std::ptrdiff_t(random() % files.size()));
      file->second[random() % file->second.size()] = std::byte(random());
      bytes = bundle(files);
    } else {
      for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = std::byte(random());
    }
    const auto scene = read_sog(bytes, "x.sog");
    if (scene) {
      EXPECT_EQ(count_non_finite(scene->cloud), 0u);
    } else {
      EXPECT_FALSE(scene.error().what.empty());
    }
  }
}

TEST(SogHostile, MetaOfTheWrongKindIsNamed) {
  using Change = std::function<void(json&)>;
  const std::vector<std::pair<Change, std::string>> cases{
      {[](json& m) { m["version"] = 3; }, "version"},
      {[](json& m) { m["version"] = "2"; }, "version"},
      {[](json& m) { m["count"] = -1; }, "count"},
      {[](json& m) { m["count"] = 2.5; }, "count"},
      {[](json& m) { m["count"] = std::uint64_t(1) << 60; }, "count"},
      {[](json& m) { m.erase("count"); }, "count"},
      {[](json& m) { m.erase("means"); }, "means"},
      {[](json& m) { m["means"]["mins"] = {1, 2}; }, "means.mins"},
      {[](json& m) { m["means"]["mins"][1] = nullptr; }, "means.mins[1]"},
      {[](json& m) { m["means"]["maxs"][2] = 1e39; }, "means.maxs[2]"},
      {[](json& m) { m["means"]["files"] = {"means_l.webp"}; }, "means.files[1]"},
      {[](json& m) { m["means"]["files"] = "means_l.webp"; }, "means.files[0]"},
      {[](json& m) { m["quats"]["files"][0] = 7; }, "quats.files[0]"},
      {[](json& m) { m["quats"] = json::array(); }, "quats.files[0]"},
      {[](json& m) { m["scales"]["codebook"] = json::array(); }, "scales.codebook"},
      {[](json& m) { m["scales"]["codebook"].push_back(1); }, "scales.codebook"},
      {[](json& m) { m["scales"]["codebook"][9] = "x"; }, "scales.codebook[9]"},
      {[](json& m) { m["scales"]["codebook"][9] = nullptr; }, "scales.codebook[9]"},
      {[](json& m) { m["sh0"].erase("codebook"); }, "sh0.codebook"},
      {[](json& m) { m["shN"]["bands"] = 4; }, "shN.bands"},
      {[](json& m) { m["shN"]["count"] = 65537; }, "shN.count"},
      {[](json& m) { m["shN"] = 1; }, "shN.files[0]"},
      {[](json& m) { m.erase("version"); }, "means.shape"}};
  for (const auto& [change, field] : cases) {
    expect_error(read_bundle(with_meta(change)), {"test.sog: meta.json: ", field});
  }
}

TEST(SogHostile, NumbersThatAreNoneAreNamed) {
  for (const char* text : {"NaN", "Infinity", "-nan", "1e999", "0x10", "01", ""}) {
    expect_error(read_bundle(with_text("5", text)), {"test.sog: meta.json: "});
  }
  Files files = small_sog();
  for (const std::string& text :
       {std::string(), std::string("[]"), std::string("{"), std::string("\xff\xfe{}"),
        std::string(100000, '['), std::string(17 << 20, ' ')}) {
    files["meta.json"] = bytes_of(text);
    expect_error(read_bundle(files), {"test.sog: meta.json: "});
  }
}

TEST(SogHostile, CountsBeyondTheImagesAreNamed) {
  expect_error(read_bundle(with_meta([](json& m) { m["count"] = 9; })),
               {"means_l.webp", "8x1", "expected 9 to "});
  for (const char* image : {"scales.webp", "quats.webp", "sh0.webp", "shN_labels.webp"}) {
    Files files = small_sog();
    files[image] = webp({{1, 1, 1, 252}}, 2, 2);
    expect_error(read_bundle(files), {image, "2x2", "expected 5 to "});
  }
}

TEST(SogHostile, IndicesBeyondTheirTablesAreNamed) {
  Files files = with_meta([](json& m) { m["scales"]["codebook"].erase(100); });
  files["scales.webp"] = webp(std::vector<Pixel>(5, {0, 255, 0, 255}));
  expect_error(read_bundle(files), {"scales.webp", "pixel 0", "index 255", "255 values"});
  files["scales.webp"] = webp(std::vector<Pixel>(5, {0, 254, 0, 255}));
  EXPECT_TRUE(read_bundle(files));  // pixels behind the last splat do not count

  expect_error(read_bundle(with_meta([](json& m) { m["sh0"]["codebook"] = {1}; })),
               {"sh0.webp", "1 values"});
  expect_error(read_bundle(with_meta([](json& m) { m["shN"]["codebook"] = {1}; })),
               {"shN_centroids.webp", "1 values"});
  expect_error(read_bundle(with_meta([](json& m) { m["shN"]["count"] = 4; })),
               {"shN_labels.webp", "pixel 4", "label 4", "4 entries"});
  files = small_sog();
  files["shN_labels.webp"] = webp(std::vector<Pixel>(5, {0, 255, 0, 255}));
  expect_error(read_bundle(files), {"shN_labels.webp", "label 65280", "5 entries"});
  expect_error(read_bundle(with_meta([](json& m) { m["shN"]["count"] = 65; })),
               {"shN_centroids.webp", "64 entries", "65"});
  expect_error(read_bundle(with_meta([](json& m) { m["shN"]["bands"] = 2; })),
               {"shN_centroids.webp", "192 pixels wide", "512"});
  files = small_sog();
  files["quats.webp"] = webp(std::vector<Pixel>(5, {0, 0, 0, 251}));
  expect_error(read_bundle(files), {"quats.webp", "mode 251"});
}

TEST(SogHostile, WebpOfOtherKindsAndLyingSizesAreNamed) {
  Files files = small_sog();
  files["quats.webp"] = webp(std::vector<Pixel>(64, {9, 9, 9, 255}), 8, 8, false);
  expect_error(read_bundle(files), {"quats.webp", "lossy"});
  files["quats.webp"] = bytes_of("\x89PNG\r\n");
  expect_error(read_bundle(files), {"quats.webp", "WebP"});
  files["quats.webp"] = {};
  expect_error(read_bundle(files), {"quats.webp", "WebP"});
  // 28 bits behind the signature byte of "VP8L" are width − 1 and height − 1.
  for (const auto& [side, reason] : {std::pair(16383u, "16383x16383"), std::pair(12u, "damaged")}) {
    files = small_sog();
    Bytes& image = files["means_u.webp"];
    const std::size_t at = text_of(image).find("VP8L") + 9;
    std::uint32_t bits = 0;
    std::memcpy(&bits, &image[at], 4);
    bits = (bits & 0xF0000000u) | (side - 1) | (side - 1) << 14;
    std::memcpy(&image[at], &bits, 4);
    expect_error(read_bundle(files), {"means_u.webp", reason});
  }
}

// An image of one colour takes some thirty bytes, whatever its size.
TEST(SogHostile, BombsOfPixelsAndSplatsAreRefused) {
  Files files = small_sog();
  files["sh0.webp"] = webp({}, 4096, 4096);
  expect_error(read_bundle(files), {"sh0.webp", "4096x4096"});
  files = small_sog();
  files["shN_centroids.webp"] = webp({}, 960, 1025);
  expect_error(read_bundle(files), {"shN_centroids.webp", "960x1025"});
  files = with_meta([](json& m) { m["count"] = 1000000; });
  for (const char* image : {"means_l.webp", "means_u.webp"}) files[image] = webp({}, 1024, 1024);
  expect_error(read_bundle(files), {"meta.json", "bytes", "1000000"});
  const TemporaryFolder folder;
  write_files(folder, files);
  expect_error(read_scene(folder / "meta.json"), {"means_l.webp", "bytes", "1000000"});
}

Bytes deflated(const std::string& name, const Bytes& content) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* memory = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_t* archive = zip_open_from_source(memory, ZIP_CREATE | ZIP_TRUNCATE, &error);
  zip_source_keep(memory);
  zip_source_t* source = zip_source_buffer(archive, content.data(), content.size(), 0);
  const zip_int64_t index = zip_file_add(archive, name.c_str(), source, 0);
  EXPECT_GE(index, 0);
  zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_DEFLATE, 9);
  EXPECT_EQ(zip_close(archive), 0);
  zip_stat_t stat;
  zip_stat_init(&stat);
  zip_source_stat(memory, &stat);
  Bytes bytes(stat.size);
  zip_source_open(memory);
  EXPECT_EQ(zip_source_read(memory, bytes.data(), bytes.size()), zip_int64_t(bytes.size()));
  zip_source_close(memory);
  zip_source_free(memory);
  return bytes;
}

void replace_all(Bytes& bytes, std::uint32_t from, std::uint32_t to) {
  int replaced = 0;
  for (std::size_t i = 0; i + 4 <= bytes.size(); ++i) {
    if (std::memcmp(&bytes[i], &from, 4) != 0) continue;
    std::memcpy(&bytes[i], &to, 4);
    ++replaced;
  }
  EXPECT_GT(replaced, 0);
}

TEST(SogHostile, DeflatedEntriesAreReadAndBombsRefused) {
  // Deflated text is read: the first thing amiss is a missing image.
  expect_error(read_sog(deflated("meta.json", small_sog()["meta.json"]), "x.sog"),
               {"means_l.webp", "not in the archive"});
  const std::uint32_t size = 9 << 20;
  Bytes bomb = deflated("meta.json", Bytes(size, std::byte{' '}));
  ASSERT_LT(bomb.size(), 20000u);
  expect_error(read_sog(bomb, "x.sog"), {"meta.json", "claims 9437184 bytes"});
  replace_all(bomb, size, 50000);  // inflates to more than it says
  expect_error(read_sog(bomb, "x.sog"), {"x.sog: meta.json"});
}

// An image compressed once more may have pixels for millions of splats in a few kilobytes.
TEST(SogHostile, MoreSplatsThanAnArchiveHasBytesForAreRefused) {
  const auto announcing = [](std::size_t count) {
    return bundle(with_meta([&](json& m) { m["count"] = count; }));
  };
  const std::size_t most = 65536 + 16 * announcing(2'000'000).size();
  ASSERT_LT(most, 2'000'000U);
  expect_error(read_sog(announcing(2'000'000), "x.sog"),
               {"x.sog: meta.json: announces 2000000 splats", fmt::format("at most {}", most)});
  expect_error(estimate_scene(announcing(2'000'000), "x.sog"), {"announces 2000000 splats"});
}

TEST(SogHostile, ArchivesOfOtherKindsAreNamed) {
  using Change = std::function<void(ZipEntry&)>;
  const std::vector<std::pair<Change, std::string>> cases{
      {[](ZipEntry& e) { e.flags = 1; }, "encrypted"},
      {[](ZipEntry& e) { e.method = 12; }, "method 12"},
      {[](ZipEntry& e) { e.method = 14; }, "method 14"},
      {[](ZipEntry& e) { e.method = 8; }, "meta.json"},  // not deflated
      {[](ZipEntry& e) { e.crc ^= 1; }, "CRC"},
      {[](ZipEntry& e) { e.packed_size = 1 << 30; }, "test.sog"},
      {[](ZipEntry& e) { e.size = 1 << 30; }, "test.sog"},
      {[](ZipEntry& e) { e.size -= 5; }, "test.sog"},
      {[](ZipEntry& e) { e.size += 5; }, "test.sog"},
      {[](ZipEntry& e) { e.name = "deep/meta.json"; }, "deep/means_l.webp"},
      {[](ZipEntry& e) { e.name = "meta.jso"; }, "not in the archive"}};
  for (const auto& [change, reason] : cases) {
    auto entries = entries_of(small_sog());
    for (ZipEntry& entry : entries) {
      if (entry.name == "meta.json") change(entry);
    }
    const auto scene = read_sog(zip_of(entries), "test.sog");
    expect_error(scene, {"test.sog", reason});
  }
}

TEST(SogHostile, DirectoriesOfOtherKindsAreNamed) {
  auto entries = entries_of(small_sog());
  while (entries.size() < 256) entries.push_back(stored(fmt::format("{}", entries.size()), {}));
  EXPECT_TRUE(read_sog(zip_of(entries), "x.sog"));
  EXPECT_TRUE(read_sog(in_zip64(zip_of(entries)), "x.sog"));
  entries.push_back(stored("more", {}));
  expect_error(read_sog(zip_of(entries), "x.sog"), {"257 entries", "256"});
  expect_error(read_sog(in_zip64(zip_of(entries)), "x.sog"), {"257 entries", "256"});
  Bytes zip = bundle(small_sog());
  const Bytes locator = bytes_of(std::string("PK\x06\x07", 4) + std::string(16, '\0'));
  zip.insert(zip.end() - 22, locator.begin(), locator.end());
  expect_error(read_sog(zip, "x.sog"), {"64-bit directory"});
  zip = bundle(small_sog());
  const Bytes end(zip.end() - 22, zip.end());
  for (int i = 0; i < 8; ++i) zip.insert(zip.end(), end.begin(), end.end());
  expect_error(read_sog(zip, "x.sog"), {"more than 8 ends"});
  expect_error(read_sog(Bytes(100), "x.sog"), {"no ZIP archive"});
  expect_error(read_sog({}, "x.sog"), {"no ZIP archive"});
  Files files = small_sog();
  files.erase("quats.webp");
  expect_error(read_bundle(files), {"quats.webp", "not in the archive"});
}

const std::vector<std::string> kBadNames{"../means_l.webp",
                                         "/etc/passwd",
                                         "a/../../means_l.webp",
                                         "./means_l.webp",
                                         "a//means_l.webp",
                                         "a/",
                                         "",
                                         ".",
                                         "..",
                                         "https://example.org/means_l.webp",
                                         "C:means_l.webp",
                                         "a\\means_l.webp",
                                         "..\\means_l.webp",
                                         std::string("means_l.webp\0.png", 17),
                                         "line\nbreak",
                                         std::string(300, 'n')};

TEST(SogHostile, NamesThatLeaveTheFolderAreRefused) {
  for (const std::string& bad : kBadNames) {
    const Files files = with_meta([&](json& m) { m["means"]["files"][0] = bad; });
    expect_error(read_bundle(files), {"test.sog: meta.json: means.files[0]", "plain name"});
    const TemporaryFolder folder;
    write_files(folder, files);
    expect_error(read_scene(folder / "meta.json"), {"means.files[0]", "plain name"});
    const json lod = {{"lodLevels", 1},
                      {"filenames", {bad}},
                      {"tree", {{"lods", {{"0", {{"file", 0}, {"offset", 0}, {"count", 5}}}}}}}};
    write_files(folder, {{"lod-meta.json", bytes_of(lod.dump())}});
    expect_error(read_scene(folder / "lod-meta.json"), {"filenames[0]", "plain name"});
  }
}

TEST(SogHostile, LinksStayInTheFolder) {
  const TemporaryFolder outside, folder;
  Files files = small_sog();
  write_files(folder, files);
  std::filesystem::rename(folder / "quats.webp", folder / "inside.webp");
  std::filesystem::create_symlink("inside.webp", folder / "quats.webp");
  EXPECT_TRUE(read_scene(folder / "meta.json"));
  std::filesystem::rename(folder / "inside.webp", outside / "quats.webp");
  std::filesystem::remove(folder / "quats.webp");
  std::filesystem::create_symlink(outside / "quats.webp", folder / "quats.webp");
  expect_error(read_scene(folder / "meta.json"), {"quats.webp", "leads out"});
  std::filesystem::remove(folder / "quats.webp");
  std::filesystem::create_directory_symlink(outside.path(), folder / "below");
  write_files(folder, with_meta([](json& m) { m["quats"]["files"][0] = "below/quats.webp"; }));
  expect_error(read_scene(folder / "meta.json"), {"below/quats.webp", "leads out"});
}

TEST(SogHostile, OnlyRegularFilesAreReadAndEachOnce) {
  const TemporaryFolder folder;
  write_files(folder, small_sog());
  std::filesystem::remove(folder / "quats.webp");
  expect_error(read_scene(folder / "meta.json"), {"quats.webp", "No such file"});
  std::filesystem::create_directory(folder / "quats.webp");
  expect_error(read_scene(folder / "meta.json"), {"quats.webp", "folder"});
  std::filesystem::remove(folder / "quats.webp");
  ASSERT_EQ(::mkfifo((folder / "quats.webp").c_str(), 0600), 0);
  expect_error(read_scene(folder / "meta.json"), {"quats.webp", "not a regular file"});
  std::filesystem::remove(folder / "quats.webp");
  std::filesystem::create_symlink("quats.webp", folder / "quats.webp");  // to itself
  expect_error(read_scene(folder / "meta.json"), {"quats.webp", "open"});
  write_files(folder, with_meta([](json& m) { m["quats"]["files"][0] = "sh0.webp"; }));
  std::filesystem::remove(folder / "quats.webp");
  write_files(folder, {{"sh0.webp", webp(std::vector<Pixel>(5, {0, 0, 0, 252}))}});
  expect_error(read_scene(folder / "meta.json"), {"sh0.webp", "twice"});
}

TEST(SogHostile, StreamedScenesThatLieAreNamed) {
  const TemporaryFolder folder;
  write_files(folder, small_sog(), "0_0/");
  const json run = {{"file", 0}, {"offset", 0}, {"count", 5}};
  const json good = {
      {"lodLevels", 1}, {"filenames", {"0_0/meta.json"}}, {"tree", {{"lods", {{"0", run}}}}}};
  const auto read = [&](const json& meta) {
    write_files(folder, {{"lod-meta.json", bytes_of(meta.dump())}});
    return read_scene(folder / "lod-meta.json");
  };
  ASSERT_TRUE(read(good));
  using Change = std::function<void(json&)>;
  const std::vector<std::pair<Change, std::string>> cases{
      {[](json& m) { m["version"] = 2; }, "version"},
      {[](json& m) { m["filenames"] = json::array(); }, "filenames"},
      {[](json& m) { m["filenames"] = {7}; }, "filenames[0]"},
      {[](json& m) { m["filenames"] = {"0_1/meta.json"}; }, "No such file"},
      {[](json& m) { m["filenames"] = {"0_0/means_l.webp"}; }, "0_0/means_l.webp"},
      {[](json& m) { m["filenames"] = {"lod-meta.json"}; }, "lod-meta.json"},
      {[](json& m) { m["tree"] = 1; }, "tree"},
      {[](json& m) { m["tree"] = json::object(); }, "no splats of level 0"},
      {[](json& m) { m["tree"]["children"] = 1; }, "children"},
      {[](json& m) { m["tree"]["children"] = {1}; }, "nodes that are objects"},
      {[](json& m) { m["tree"]["lods"]["0"] = 1; }, "lods"},
      {[](json& m) { m["tree"]["lods"]["0"]["file"] = 1; }, "lods"},
      {[](json& m) { m["tree"]["lods"]["0"]["file"] = -1; }, "lods"},
      {[](json& m) { m["tree"]["lods"]["0"]["count"] = 1e18; }, "lods"},
      {[](json& m) { m["tree"]["lods"]["0"]["count"] = 0; }, "no splats of level 0"},
      {[](json& m) { m["tree"]["lods"]["0"]["count"] = 6; }, "holds 5 splats"},
      {[](json& m) { m["tree"]["children"] = {m["tree"], m["tree"]}; }, "expects 15"},
      {[](json& m) {
         m["filenames"] = {"0_0/meta.json", "0_0/meta.json"};
         json second = m["tree"];
         second["lods"]["0"]["file"] = 1;
         m["tree"]["children"] = {second};
       },
       "twice"}};
  for (const auto& [change, reason] : cases) {
    json meta = good;
    change(meta);
    expect_error(read(meta), {reason});
  }
  json deep = good["tree"];
  for (int i = 0; i < 40; ++i) deep = {{"children", {deep}}};
  json meta = good;
  meta["tree"] = deep;
  expect_error(read(meta), {"lod-meta.json", "nested"});
}

}  // namespace
}  // namespace fluxgs
