// fluxgs web: pages of scenes, made from a small viewer of our own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "run_command.h"
#include "support/scenes.h"
#include "support/temp_folder.h"
#include "tools/fluxgs/commands/web_page.h"

namespace fluxgs {
namespace {

using test::expect_error;
using test::fluxgs;
using test::Outcome;
using test::quoted;
using test::text_of;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPage =
    "<!doctype html>\n<title>Flux-GS viewer</title>\n"
    "<flux-gs-viewer></flux-gs-viewer>\n<!-- scene -->\n";

std::span<const std::byte> bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

/// A folder of the viewer and a scene.
class Web : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "viewer/page");
    for (const char* name : {"viewer/page.html", "viewer/page/index.html"})
      ASSERT_TRUE(write_file_atomic(folder_ / name, bytes(kPage)));
    ASSERT_TRUE(write_file_atomic(folder_ / "viewer/page/viewer.js", bytes("js")));
    ASSERT_TRUE(write_scene(folder_ / "garden.ply", test::random_cloud(50, 1, 1)));
  }
  Outcome web(const std::string& arguments) {
    return fluxgs(fmt::format("web {} {}", quoted(folder_ / "garden.ply"), arguments),
                  "FLUXGS_WEB=" + quoted(folder_ / "viewer"));
  }
  std::string out(const char* name) { return quoted(folder_ / name); }
  test::TempFolder folder_;
};

TEST_F(Web, OneFileHoldsTheSceneAndItsPicture) {
  const Outcome done = web("-o " + out("g.html") + " --title 'A & \"B\" <c>' --background 1,0,0.5");
  ASSERT_EQ(done.status, 0) << done.err;
  const std::string page = text_of(folder_ / "g.html");
  EXPECT_THAT(page, HasSubstr("<title>A &amp; &quot;B&quot; &lt;c&gt;</title>"));
  EXPECT_THAT(page, HasSubstr("name=\"A &amp; &quot;B&quot; &lt;c&gt;\""));
  EXPECT_THAT(page, HasSubstr("background=\"#ff0080\""));
  EXPECT_THAT(page, HasSubstr("poster=\"data:image/jpeg;base64,/9j/"));
  EXPECT_THAT(page, HasSubstr("id=\"flux-gs-scene\">H4sI"));  // gzip
  EXPECT_THAT(page, Not(HasSubstr("src=")));
}

TEST_F(Web, AFolderHoldsFiles) {
  const Outcome done =
      web("-o " + out("site") + " --address https://example.org/g --turntable --json");
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(nlohmann::json::parse(done.out)["files"].size(), 4U);
  const std::string page = text_of(folder_ / "site/index.html");
  EXPECT_THAT(page, HasSubstr("src=\"garden.ply\""));
  EXPECT_THAT(page, HasSubstr("og:image\" content=\"https://example.org/g/poster.jpg\""));
  EXPECT_THAT(page, HasSubstr(" turntable>"));
  EXPECT_EQ(text_of(folder_ / "site/viewer.js"), "js");
  EXPECT_EQ(text_of(folder_ / "site/garden.ply"), text_of(folder_ / "garden.ply"));
  expect_error(web("-o " + out("site")), {"index.html", "--force"});
  EXPECT_EQ(web("-o " + out("site") + " --force --no-poster").status, 0);
}

TEST_F(Web, FilesThatAreThereStay) {
  std::filesystem::create_directory(folder_ / "site");
  for (const char* name : {"viewer.js", "garden.ply", "poster.jpg"}) {
    ASSERT_TRUE(write_file_atomic(folder_ / "site" / name, bytes("mine")));
    expect_error(web("-o " + out("site")), {name, "exists", "--force"});
    EXPECT_EQ(text_of(folder_ / "site" / name), "mine");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "site/index.html"));
    std::filesystem::remove(folder_ / "site" / name);
  }
  for (const char* name : {"viewer.js", "poster.jpg"}) {
    std::filesystem::rename(folder_ / "garden.ply", folder_ / name);
    expect_error(
        fluxgs(fmt::format("web {} -o {}", out(name), out("other")), "FLUXGS_WEB=" + out("viewer")),
        {name, "rename the scene"});
    std::filesystem::rename(folder_ / name, folder_ / "garden.ply");
  }
}

TEST_F(Web, NamesOfScenesAreAsked) {
  constexpr const char* kName = "na me#?%20&.ply";
  std::filesystem::rename(folder_ / "garden.ply", folder_ / kName);
  const Outcome done =
      fluxgs(fmt::format("web {} -o {}", out(kName), out("site")), "FLUXGS_WEB=" + out("viewer"));
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "site" / kName));
  EXPECT_THAT(text_of(folder_ / "site/index.html"), HasSubstr("src=\"na%20me%23%3F%2520%26.ply\""));
}

// A page reads the bytes of one file.
TEST_F(Web, ScenesOfSeveralFilesAreRefused) {
  ASSERT_TRUE(write_scene(folder_ / "s.glb", test::random_cloud(50, 1, 1)));
  const std::string glb = text_of(folder_ / "s.glb");
  constexpr std::size_t kJson = 20, kHeader = 8;  // glTF 2.0, binary format: two chunks
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  auto gltf = nlohmann::json::parse(glb.substr(kJson, length));
  gltf["buffers"][0]["uri"] = "s.bin";
  ASSERT_TRUE(write_file_atomic(folder_ / "s.bin", bytes(glb.substr(kJson + length + kHeader))));
  ASSERT_TRUE(write_file_atomic(folder_ / "s.gltf", bytes(gltf.dump())));
  const auto page_of = [&](const char* name) {
    return fluxgs(fmt::format("web {} -o {}", quoted(folder_ / name), out("s.html")),
                  "FLUXGS_WEB=" + quoted(folder_ / "viewer"));
  };
  const Outcome refused = page_of("s.gltf");
  expect_error(refused, {"s.gltf: a page shows a scene that is one file"});
  // The proposed command works as it stands
  const std::size_t at = refused.err.find("`fluxgs convert ");
  ASSERT_NE(at, std::string::npos);
  const std::string advice = refused.err.substr(at + 8, refused.err.find("scene.glb`") - at - 8);
  EXPECT_EQ(fluxgs(advice + out("scene.glb")).status, 0);
  ASSERT_TRUE(write_file_atomic(folder_ / "page.glb", bytes("<!doctype html><p>Sign in")));
  const Outcome none = page_of("page.glb");
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, Not(HasSubstr("convert")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "s.html"));
}

TEST_F(Web, AddressesAreOfFolders) {
  expect_error(web("-o " + out("site") + " --address javascript:x"), {"--address", "https://"});
  expect_error(web("-o " + out("g.HTML") + " --address https://example.org"),
               {"--address", "is for a folder"});
  EXPECT_EQ(web("-o " + out("g.HTM")).status, 0);
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "g.HTM"));
}

TEST_F(Web, WhatIsMissingIsSaid) {
  const Outcome none = fluxgs(fmt::format("web {} -o {}", out("garden.ply"), out("g.html")),
                              "FLUXGS_WEB=" + quoted(folder_ / "nowhere"));
  expect_error(none, {"nowhere", "tools/web/build"});
  ASSERT_TRUE(write_file_atomic(folder_ / "viewer/page.html", bytes("<p>another page")));
  expect_error(web("-o " + out("g.html")), {"page.html", "another version"});
  ASSERT_TRUE(write_file_atomic(folder_ / "garden.ply", bytes("not a scene")));
  expect_error(web("-o " + out("g.html")), {"garden.ply", "format"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "g.html"));
}

TEST(WebPage, Base64) {
  // RFC 4648, section 10
  const auto encoded = [](const std::string& text) { return cli::base64(bytes(text)); };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace fluxgs
