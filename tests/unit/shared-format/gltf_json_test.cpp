// The JSON form of glTF: buffers inside as data: URIs, and files beside.
#include <filesystem>
#include <fstream>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "fluxgs/io/scene_estimate.h"
#include "glb_support.h"
#include "support/temp_folder.h"

namespace fluxgs {
namespace {

using namespace test;

/// A .glb as a .gltf whose buffer has this URI.
std::string gltf_text(const Bytes& glb, const std::string& uri) {
  std::string text = json_of(glb);
  const std::string buffers = R"("buffers":[{)";
  const std::size_t at = text.find(buffers);
  EXPECT_NE(at, text.npos);
  return text.insert(at + buffers.size(), fmt::format(R"("uri":"{}",)", uri));
}

std::string inside(const Bytes& glb, const std::string& type = "application/octet-stream") {
  return gltf_text(glb, fmt::format("data:{};base64,{}", type, base64(bin_of(glb))));
}

class GltfJson : public testing::Test {
 protected:
  void write(const std::string& name, const Bytes& bytes) {
    ASSERT_TRUE(write_file_atomic(folder_ / name, bytes));
  }
  Expected<SceneFile> scene(const std::string& text, const std::string& name = "s.gltf") {
    write(name, bytes_of(text));
    return read_scene(folder_ / name);
  }
  void expect_scene(const Expected<SceneFile>& scene) {
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->format, "gltf");
    EXPECT_EQ(scene->cloud.positions, cloud_.positions);
    EXPECT_EQ(scene->cloud.sh_rest, cloud_.sh_rest);
  }

  TempFolder folder_;
  const SplatCloud cloud_ = random_cloud(30, 2, 8);
  const Bytes glb_ = *encode_glb(cloud_, "s.glb");
  const Bytes bin_ = bin_of(glb_);
};

TEST_F(GltfJson, ReadsBuffersInside) {
  for (const char* type :
       {"application/octet-stream", "application/gltf-buffer", "", "x;charset=y"})
    expect_scene(scene(inside(glb_, type)));
  // From memory, too
  FLUXGS_UNWRAP(memory, read_scene(bytes_of(inside(glb_)), "s.gltf"));
  EXPECT_EQ(memory.cloud.positions, cloud_.positions);
  EXPECT_EQ(memory.bytes, inside(glb_).size());
  // Some writers escape slashes, others leave padding out or begin with a byte order mark
  std::string escaped = inside(glb_);
  for (std::size_t at = escaped.find("base64"); (at = escaped.find('/', at)) != escaped.npos;
       at += 2)
    escaped.insert(at, 1, '\\');
  expect_scene(scene(escaped));
  std::string bare = inside(glb_);
  std::erase(bare, '=');
  expect_scene(scene(bare));
  expect_scene(scene("\xef\xbb\xbf \n" + inside(glb_)));
}

TEST_F(GltfJson, ReadsFilesBeside) {
  std::filesystem::create_directory(folder_ / "deep");
  for (const char* name :
       {"splats.bin", "two words.bin", "b\xc3\xa4r.bin", "deep/s.bin", "100%.bin"})
    write(name, bin_);
  for (const char* uri : {"splats.bin", "./splats.bin", "two%20words.bin", "two words.bin",
                          "b%C3%A4r.bin", "b\xc3\xa4r.bin", "deep/s.bin", "100%25.bin"}) {
    const auto found = scene(gltf_text(glb_, uri));
    expect_scene(found);
    EXPECT_EQ(found->bytes, gltf_text(glb_, uri).size() + bin_.size()) << uri;
  }
  Bytes padded = bin_;
  padded.resize(bin_.size() + 100);
  write("padded.bin", padded);
  expect_scene(scene(gltf_text(glb_, "padded.bin")));
}

// A .glb may have buffers outside, and its chunk beside them.
TEST_F(GltfJson, ABinaryFileMayHaveFilesBeside) {
  write("splats.bin", bin_);
  const Bytes glb = make_glb(gltf_text(glb_, "splats.bin"));
  write("s.glb", glb);
  FLUXGS_UNWRAP(found, read_scene(folder_ / "s.glb"));
  EXPECT_EQ(found.format, "glb");
  EXPECT_EQ(found.cloud.positions, cloud_.positions);
  expect_error(read_scene(glb, "s.glb"), {"buffers[0].uri", "splats.bin", "not read from memory"});
}

TEST_F(GltfJson, SeveralBuffersAreReadWhereTheyAreNeeded) {
  using nlohmann::json;
  json root = json::parse(json_of(glb_));
  const std::size_t half = root["bufferViews"][4]["byteOffset"];
  for (json& view : root["bufferViews"])
    if (const std::size_t at = view["byteOffset"]; at >= half) {
      view["buffer"] = 1;
      view["byteOffset"] = at - half;
    }
  const auto part = [&](std::size_t from, std::size_t to) {
    return Bytes(bin_.begin() + std::ptrdiff_t(from), bin_.begin() + std::ptrdiff_t(to));
  };
  const Bytes first = part(0, half), second = part(half, bin_.size());
  write("one.bin", first);
  root["buffers"] =
      json::array({{{"uri", "one.bin"}, {"byteLength", first.size()}},
                   {{"uri", "data:;base64," + base64(second)}, {"byteLength", second.size()}},
                   {{"uri", "missing.bin"}, {"byteLength", 7}},
                   {{"byteLength", 9}}});
  root["images"] = json::array({{{"uri", "missing.png"}}});
  expect_scene(scene(root.dump()));
  // The same file for both
  write("both.bin", bin_);
  root["buffers"][0] = {{"uri", "both.bin"}, {"byteLength", bin_.size()}};
  root["buffers"][1] = root["buffers"][0];
  for (json& view : root["bufferViews"])
    if (view["buffer"] == 1) view["byteOffset"] = view["byteOffset"].get<std::size_t>() + half;
  expect_scene(scene(root.dump()));
  root["bufferViews"][0]["buffer"] = 3;
  expect_error(scene(root.dump()), {"buffers[3]", "no uri"});
  root["bufferViews"][0]["buffer"] = 4;
  expect_error(scene(root.dump()), {"buffers[4]", "does not exist"});
  root["bufferViews"][0]["buffer"] = 2;
  expect_error(scene(root.dump()), {"buffers[2].uri: ", "missing.bin", "No such file"});
}

TEST_F(GltfJson, ASceneThatShowsNothingSaysSo) {
  nlohmann::json root = nlohmann::json::parse(json_of(glb_));
  write("splats.bin", bin_);
  root["buffers"][0]["uri"] = "splats.bin";
  root["scenes"][0]["nodes"] = nlohmann::json::array();
  const auto empty = scene(root.dump());
  ASSERT_TRUE(empty) << empty.error().message();
  EXPECT_EQ(empty->cloud.size(), 0U);
  EXPECT_THAT(empty->warnings, testing::ElementsAre(testing::HasSubstr("no node of its scene")));
}

TEST_F(GltfJson, FilesElsewhereAreRefused) {
  TempFolder outside;
  ASSERT_TRUE(write_file_atomic(outside / "secret.bin", bin_));
  std::filesystem::create_symlink(outside / "secret.bin", folder_ / "link.bin");
  std::filesystem::create_directory(folder_ / "folder.bin");
  const std::string absolute = (outside / "secret.bin").string();
  const std::string up = "../" + outside.path().filename().string() + "/secret.bin";
  for (const std::string& uri :
       {absolute, up, "file://" + absolute, "%2e%2e/" + up.substr(3), std::string("folder.bin"),
        std::string("link.bin"), std::string("deep/../../x"), std::string("a\\\\b.bin"),
        std::string("https://example.org/splats.bin"), std::string(300, 'x')})
    EXPECT_FALSE(scene(gltf_text(glb_, uri))) << uri;
  expect_error(scene(gltf_text(glb_, "link.bin")), {"link.bin", "leads out"});
}

TEST_F(GltfJson, SizesAreCheckedBeforeFilesAreRead) {
  write("short.bin", Bytes(bin_.begin(), bin_.end() - 1));
  expect_error(scene(gltf_text(glb_, "short.bin")),
               {"buffers[0].byteLength", fmt::format("holds {} bytes", bin_.size() - 1)});
  // Sparse: takes no disk, and would take all memory
  std::ofstream(folder_ / "huge.bin").close();
  std::filesystem::resize_file(folder_ / "huge.bin", std::uintmax_t(1) << 40);
  expect_error(scene(gltf_text(glb_, "huge.bin")), {"huge.bin", "1099511627776"});
}

TEST_F(GltfJson, OtherJsonIsNotMistakenForIt) {
  for (const char* text : {"{}", R"({"asset":{"version":"1.0"},"root":{}})", R"({"frames":[]})",
                           R"(["asset","meshes"])", R"({"meshes":[]})"})
    EXPECT_FALSE(is_gltf(bytes_of(text))) << text;
  expect_error(scene(R"({"asset":{"version":"1.0"},"scenes":[]})"), {"asset.version", "1.0"});
  expect_error(scene(R"({"asset":{"version":"2.0"},"meshes":[]})"), {"meshes", "expected splats"});
  expect_error(scene(R"({"asset":{"version":"2.0"},"meshes":[)"), {"is not JSON"});
}

TEST_F(GltfJson, CutAtAnyByteIsAnError) {
  std::string text = inside(small_glb(2, 0));
  text.erase(text.find_last_not_of(' ') + 1);
  for (std::size_t size = 0; size < text.size(); ++size)
    EXPECT_FALSE(read_gltf(bytes_of(text.substr(0, size)), "x")) << size;
}

TEST_F(GltfJson, AnnouncesItsSplats) {
  FLUXGS_UNWRAP(estimate, estimate_scene(bytes_of(inside(glb_)), "s.gltf"));
  EXPECT_EQ(estimate.format, "gltf");
  EXPECT_EQ(estimate.splats, 30u);
  EXPECT_EQ(estimate.sh_degree, 2);
}

}  // namespace
}  // namespace fluxgs
