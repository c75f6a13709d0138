// fluxgs web: pages of scenes, made from a small viewer of our own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
