// The window of fluxgs view: its content, its controls, and its errors.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/io/scene.h"
#include "platform/host/window_screen.h"
#include "run_command.h"
#include "some_track.h"
#include "support/scenes.h"
#include "tools/fluxgs/cameras/initial_view.h"
#include "tools/fluxgs/cameras/view_script.h"
#include "trainer/data/image_io.h"
#include "viewer/mouse_and_keys.h"
#include "virtual_display.h"

namespace fluxgs {
namespace {

using nlohmann::json;
using test::expect_error;
using test::fluxgs;
using test::Outcome;
using test::quoted;

/// dB between two images; of the second one mirrored or turned upside down if asked.
double psnr(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b, bool mirror = false,
            bool turn = false) {
  double sum = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const int from = *(b.at(mirror ? b.width - 1 - x : x, turn ? b.height - 1 - y : y) + c);
        const int error = a.at(x, y)[c] - from;
        sum += error * error;
      }
  const double mean = sum / (3.0 * a.width * a.height);
  return mean > 0 ? 10 * std::log10(255 * 255 / mean) : 200;
}

class Window : public testing::Test {
 protected:
  void SetUp() override {
    const auto library = host::window_library_version();
    if (!library) GTEST_SKIP() << library.error().message();
    if (!display_.available()) GTEST_SKIP() << "Xvfb is not installed (package xvfb)";
    ASSERT_TRUE(write_scene(folder_ / "scene.ply", test::random_cloud(400, 1, 8)));
  }

  Outcome view(const std::string& more) {
    return fluxgs(
        fmt::format("view {} --renderer {} {}", quoted(folder_ / "scene.ply"), renderer_, more),
        "DISPLAY=" + display_.name());
  }

  /// With a script; the image goes to window.png.
  Outcome play(const json& script, int frames, const std::string& more = "") {
    std::ofstream(folder_ / "script.json") << script;
    return view(fmt::format("--size 320x240 --input {} --frames {} --screenshot {} {}",
                            quoted(folder_ / "script.json"), frames, quoted(folder_ / "window.png"),
                            more));
  }

  /// The window shows what `render` draws from the camera that the window printed.
  void expect_window_shows(const Outcome& viewed, int width, int height) {
    ASSERT_EQ(viewed.status, 0) << viewed.err;
    std::ofstream(folder_ / "camera.json") << viewed.out;
    const Outcome rendered = fluxgs(fmt::format(
        "render {} --camera {} --size {}x{} -o {}", quoted(folder_ / "scene.ply"),
        quoted(folder_ / "camera.json"), width, height, quoted(folder_ / "rendered.png")));
    ASSERT_EQ(rendered.status, 0) << rendered.err;
    const auto shown = read_image(folder_ / "window.png");
    const auto expected = read_image(folder_ / "rendered.png");
    ASSERT_TRUE(shown && expected);
    ASSERT_EQ(shown->width, width);
    ASSERT_EQ(shown->height, height);
    EXPECT_GT(psnr(*shown, *expected), 45);
    // A scene that looks like that from any side would show nothing
    EXPECT_LT(psnr(*shown, *expected, true, false), 30);
    EXPECT_LT(psnr(*shown, *expected, false, true), 30);
  }

  std::string renderer_ = "gles";
  test::VirtualDisplay display_{"800x600"};
  test::TempFolder folder_;
};

const json kPrint = {{"step", 0}, {"type", "p"}};

TEST_F(Window, ShowsWhatRenderDraws) {
  expect_window_shows(play(json::array({kPrint}), 2), 320, 240);
}

TEST_F(Window, ShowsWhatTheProcessorDraws) {
  const json script = {{{"step", 1}, {"resize", {301, 203}}},
                       {{"step", 3}, {"scroll", 2}, {"at", {50, 100}}},
                       {{"step", 20}, {"lose_context", true}},
                       {{"step", 39}, {"type", "p"}}};
  renderer_ = "cpu";
  const Outcome by_processor = play(script, 40);
  EXPECT_NE(by_processor.err.find("drawn by the processor"), std::string::npos) << by_processor.err;
  expect_window_shows(by_processor, 301, 203);
  const auto shown = read_image(folder_ / "window.png");
  renderer_ = "gles";
  expect_window_shows(play(script, 40), 301, 203);
  const auto by_opengl = read_image(folder_ / "window.png");
  ASSERT_TRUE(shown && by_opengl);
  EXPECT_GT(psnr(*shown, *by_opengl), 50);
}

TEST_F(Window, PlaysAPath) {
  json track = json::parse(test::some_track());
  track["animTracks"][0]["loopMode"] = "none";
  std::ofstream(folder_ / "path.json") << track;
  const Outcome played = play(json::array({{{"step", 250}, {"type", "p"}}}), 251,
                              "--path " + quoted(folder_ / "path.json"));
  expect_window_shows(played, 320, 240);
  const json end = json::parse(played.out)[0]["position"];
  EXPECT_NEAR(end[2].get<double>(), -4, 1e-6) << "the last key";
  const Outcome rendered = fluxgs(
      fmt::format("render {} --path {} --fps 2 --size 32x24 -o {}", quoted(folder_ / "scene.ply"),
                  quoted(folder_ / "path.json"), quoted(folder_ / "frame.png")));
  ASSERT_EQ(rendered.status, 0) << rendered.err;
  for (const char* name : {"frame_000.png", "frame_001.png", "frame_006.png"})
    EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "frame_007.png"));
}

TEST_F(Window, SaysWhatIsWrongWithAPath) {
  json track = json::parse(test::some_track());
  track["animTracks"][0]["keyframes"]["times"] = {0, 2, 1};
  std::ofstream(folder_ / "path.json") << track;
  for (const char* command : {"view --frames 1 ", "render -o a.png "})
    expect_error(fluxgs(command + quoted(folder_ / "scene.ply") + " --path " +
                        quoted(folder_ / "path.json")),
                 {"path.json", "animTracks[0].keyframes.times[2]", "later time"});
}

// --follow: what is drawn last is what was written last
TEST_F(Window, FollowsAFileThatIsWrittenAgain) {
  ASSERT_TRUE(write_scene(folder_ / "other.ply", test::random_cloud(300, 1, 9)));
  std::ofstream(folder_ / "camera.json")
      << R"([{"name":"a","position":[0,0,-4],"target":[0,0,0],"up":[0,-1,0],"fovY":50}])";
  const std::string options = "--size 64x48 --camera " + quoted(folder_ / "camera.json");
  const auto shot = [&](const char* name) { return " --screenshot " + quoted(folder_ / name); };
  std::ofstream(folder_ / "follow.sh") << fmt::format(
      "'{}' view {} {} --follow --frames 3000 {} 2>{} &\n"
      "while ! grep -q 'GL renderer' {} && kill -0 $!; do sleep 0.01; done\n"
      "mv {} {}\nwait $!\n",
      test::kFluxgs, quoted(folder_ / "scene.ply"), options, shot("followed.png"),
      quoted(folder_ / "err"), quoted(folder_ / "err"), quoted(folder_ / "other.ply"),
      quoted(folder_ / "scene.ply"));
  const std::string before = fmt::format("DISPLAY={} ", display_.name());
  ASSERT_EQ(std::system((before + "sh " + quoted(folder_ / "follow.sh")).c_str()), 0)
      << test::text_of(folder_ / "err");
  ASSERT_EQ(view(options + " --frames 3" + shot("other.png")).status, 0);
  const auto followed = read_image(folder_ / "followed.png");
  const auto other = read_image(folder_ / "other.png");
  ASSERT_TRUE(followed && other);
  EXPECT_GT(psnr(*followed, *other), 45);
}

TEST_F(Window, FollowsTheMouseTheKeysAndItsSize) {
  const json script = {
      {{"step", 1}, {"button", "left"}, {"down", true}, {"at", {100, 100}}},
      {{"step", 2}, {"move", {130, 90}}},
      {{"step", 3}, {"move", {150, 120}}},
      {{"step", 3}, {"button", "left"}, {"down", false}, {"at", {150, 120}}},
      {{"step", 6}, {"resize", {333, 401}}},
      {{"step", 8}, {"scroll", 2}, {"at", {50, 300}}},
      {{"step", 9}, {"key", "D"}, {"down", true}},
      {{"step", 15}, {"key", "D"}, {"down", false}},
      {{"step", 16}, {"type", "f"}},
      {{"step", 40}, {"button", "right"}, {"down", true}, {"at", {10, 10}}},
      {{"step", 41}, {"move", {20, 5}}},
      {{"step", 42}, {"button", "right"}, {"down", false}, {"at", {20, 5}}},
      {{"step", 119}, {"type", "p"}},
  };
  expect_window_shows(play(script, 120, "--up 0,-1,0"), 333, 401);
}

TEST_F(Window, CanBeResizedBeforeEveryFrame) {
  json script = json::array();
  for (int i = 0; i < 60; ++i)
    script.push_back({{"step", i}, {"resize", {100 + 7 * (i % 40), 300 - 4 * (i % 55)}}});
  script.push_back({{"step", 60}, {"resize", {1, 1}}});
  script.push_back({{"step", 61}, {"resize", {211, 97}}});
  script.push_back({{"step", 62}, {"type", "p"}});
  expect_window_shows(play(script, 70), 211, 97);
}

TEST_F(Window, IsNotDrawnAgainWhileNothingMoves) {
  const json script = {{{"step", 100}, {"move", {5, 5}}},
                       {{"step", 200}, {"scroll", 1}, {"at", {9, 9}}},
                       {{"step", 300}, {"key", "Escape"}, {"down", true}}};
  std::ofstream(folder_ / "script.json") << script;
  const Outcome o = view("--input " + quoted(folder_ / "script.json"));
  ASSERT_EQ(o.status, 0) << o.err;
  int drawn = 0, steps = 0;
  const std::size_t at = o.err.rfind("\n", o.err.size() - 2);
  ASSERT_EQ(std::sscanf(o.err.c_str() + at + 1, "%d frames drawn in %d steps", &drawn, &steps), 2)
      << o.err;
  EXPECT_EQ(steps, 301);
  EXPECT_GE(drawn, 2);
  EXPECT_LE(drawn, 8);  // a new window may be uncovered more than once
}

TEST_F(Window, SurvivesTheLossOfItsContext) {
  const Outcome o = play(json::array({{{"step", 3}, {"lose_context", true}},
                                      {{"step", 5}, {"lose_context", true}},
                                      {{"step", 7}, {"type", "p"}}}),
                         9);
  EXPECT_NE(o.err.find("the graphics context was lost; it was made again"), std::string::npos);
  expect_window_shows(o, 320, 240);
}

TEST_F(Window, ShowsFewerSplatsWhereMemoryIsShort) {
  const Outcome coarse = view("--size 64x48 --frames 2 --memory 0.108");
  EXPECT_EQ(coarse.status, 0) << coarse.err;
  EXPECT_NE(coarse.err.find("colours are blended in half floats"), std::string::npos) << coarse.err;
  EXPECT_EQ(coarse.err.find("of 400 splats"), std::string::npos) << coarse.err;
  const Outcome o = view("--size 64x48 --frames 2 --memory 0.068");
  EXPECT_EQ(o.status, 0) << o.err;
  int shown = 0, all = 0;
  const char* text = "graphics memory is short: ";
  const std::size_t at = o.err.find(text);
  ASSERT_NE(at, std::string::npos) << o.err;
  ASSERT_EQ(std::sscanf(o.err.c_str() + at + std::strlen(text), "%d of %d splats", &shown, &all),
            2);
  EXPECT_EQ(all, 400);
  EXPECT_GT(shown, 40);
  EXPECT_LT(shown, 400);
  // In the end fewer pixels, enlarged
  const Outcome small = play(json::array({kPrint}), 2, "--memory 0.6");
  EXPECT_EQ(small.status, 0) << small.err;
  EXPECT_NE(small.err.find("images of 160x120 pixels are enlarged"), std::string::npos)
      << small.err;
  expect_error(view("--frames 2 --memory 0.001"),
               {"graphics memory: 1000 bytes do not hold one pixel and one splat"});
  EXPECT_EQ(view("--frames 2 --memory nan").status, 2);
}

TEST_F(Window, LooksAtAnEmptyScene) {
  ASSERT_TRUE(write_scene(folder_ / "scene.ply", SplatCloud()));
  const json script = {{{"step", 0}, {"button", "left"}, {"down", true}, {"at", {9, 9}}},
                       {{"step", 1}, {"button", "left"}, {"down", false}, {"at", {9, 9}}},
                       {{"step", 2}, {"button", "left"}, {"down", true}, {"at", {9, 9}}}};
  EXPECT_EQ(play(script, 5).status, 0);
}

TEST(ViewCommand, SaysWhereThereIsNoDisplay) {
  if (!host::window_library_version()) GTEST_SKIP() << "libglfw3 is not installed";
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "scene.ply", test::random_cloud(10, 0)));
  expect_error(fluxgs("view " + quoted(folder / "scene.ply"), "env -u DISPLAY -u WAYLAND_DISPLAY"),
               {"window: no display", "expected a graphical session", "fluxgs render"});
  expect_error(fluxgs("view " + quoted(folder / "scene.ply"), "DISPLAY=:54321"),
               {"window: no display"});
}

TEST(ViewCommand, BadArguments) {
  const test::TempFolder folder;
  const std::string scene = quoted(folder / "scene.ply");
  ASSERT_TRUE(write_scene(folder / "scene.ply", test::random_cloud(10, 0)));
  for (const char* up : {"0,0,0", "1,2", "1,2,3,4", "nan,0,1", "north", "1,2,x", ""})
    EXPECT_EQ(fluxgs(fmt::format("view {} --up '{}'", scene, up)).status, 2) << up;
  EXPECT_EQ(fluxgs("view " + scene + " --screenshot x.png").status, 2);
  EXPECT_EQ(fluxgs("view " + scene + " --frames 0").status, 2);
  expect_error(fluxgs("view " + scene + " --frames 1 --screenshot x.jpg"), {"x.jpg", ".png"});
  expect_error(fluxgs("view " + quoted(folder / "none.ply")), {"none.ply"});
  const auto with_script = [&](const std::string& text) {
    std::ofstream(folder / "script.json") << text;
    return fluxgs(fmt::format("view {} --input {}", scene, quoted(folder / "script.json")));
  };
  expect_error(with_script("{}"), {"script.json", "JSON list"});
  for (const char* event :
       {"1", "{}", R"({"step":1})", R"({"step":-1,"type":"f"})", R"({"step":1,"type":"ff"})",
        R"({"step":1,"move":[1]})", R"({"step":1,"move":[1,1e99]})", R"({"step":1,"resize":[0,9]})",
        R"({"step":1,"button":"fourth","down":true,"at":[1,1]})", R"({"step":1,"key":"W"})",
        R"({"step":1,"scroll":"up","at":[1,1]})"})
    expect_error(with_script(fmt::format("[{}]", event)), {"script.json: event 0", "expected"});
  expect_error(with_script(R"([{"step":2,"type":"f"},{"step":1,"type":"f"}])"),
               {"event 1: step", "order"});
  const Outcome help = fluxgs("view --help");
  EXPECT_NE(help.out.find("double click"), std::string::npos);
  EXPECT_NE(help.out.find("Example: fluxgs view"), std::string::npos);
}

using viewer::PointerButton;
using viewer::WindowEvent;
using Kind = WindowEvent::Kind;

/// A window of 640×480 that nobody sees.
struct Desk {
  camera::Navigation n = camera::navigation_from(
      camera::view_between({0, 0, -5}, {0, 0, 0}, {0, -1, 0}, 1), {0, -1, 0}, {});
  viewer::MouseAndKeys input;
  double time = 0;

  std::optional<glm::dvec2> tell(const WindowEvent& event) {
    return viewer::apply(event, time, {640, 480}, input, n);
  }
  std::optional<glm::dvec2> press(const glm::dvec2& at, bool down,
                                  PointerButton button = PointerButton::left) {
    return tell({.kind = Kind::button, .position = at, .button = button, .down = down});
  }
  void move(const glm::dvec2& to) { tell({.kind = Kind::pointer_moved, .position = to}); }
  void key(char key, bool down) { tell({.kind = Kind::key, .down = down, .key = key}); }
};

TEST(ViewInput, DoubleClicksAreTwoNearInTimeAndPlace) {
  Desk desk;
  const auto click = [&](double time, const glm::dvec2& at) {
    desk.time = time;
    const bool focus = desk.press(at, true).has_value();
    desk.press(at, false);
    return focus;
  };
  EXPECT_FALSE(click(0, {100, 100}));
  EXPECT_TRUE(click(0.2, {102, 100}));
  EXPECT_FALSE(click(0.3, {102, 100}));  // the third
  EXPECT_FALSE(click(5, {102, 100}));
  EXPECT_FALSE(click(5.2, {152, 100}));
}

TEST(ViewInput, DragsTurnMoveAndLook) {
  Desk desk;
  desk.move({50, 50});
  EXPECT_EQ(desk.n.view.target, glm::dvec3(0.0));
  const auto dragged = [](Desk d, PointerButton button) {
    d.press({100, 100}, true, button);
    d.move({120, 100});
    return d.n.view;
  };
  const auto orbited = dragged(desk, PointerButton::left);
  EXPECT_EQ(orbited.target, glm::dvec3(0.0));
  EXPECT_GT(glm::distance(camera::eye(orbited), glm::dvec3(0, 0, -5)), 0.1);
  const auto panned = dragged(desk, PointerButton::middle);
  EXPECT_LT(panned.target.x, -0.01);
  desk.key('W', true);
  EXPECT_EQ(desk.n.flying.forward, 1);
  const auto looked = dragged(desk, PointerButton::left);
  EXPECT_LT(glm::distance(camera::eye(looked), glm::dvec3(0, 0, -5)), 1e-9);
  desk.key('S', true);
  EXPECT_EQ(desk.n.flying.forward, 0);
  desk.tell({.kind = Kind::focus_lost});
  EXPECT_FALSE(camera::moving(desk.n));
}

TEST(ViewInput, ThrowsGoOnAndRestsDoNot) {
  for (const bool rests : {false, true}) {
    Desk desk;
    desk.press({100, 100}, true);
    for (int i = 1; i <= 5; ++i) {
      desk.time = 0.016 * i;
      desk.move({100 + 20 * i, 100});
    }
    if (rests) desk.time += 0.5;
    desk.press({200, 100}, false);
    EXPECT_EQ(camera::moving(desk.n), !rests);
  }
}

TEST(ViewInput, KeysDoWhatTheHelpSays) {
  Desk desk;
  const auto type = [&](char letter) { return desk.tell({.kind = Kind::text, .key = letter}); };
  type('+');
  EXPECT_DOUBLE_EQ(desk.n.speed_factor, 1.5);
  type('-');
  EXPECT_DOUBLE_EQ(desk.n.speed_factor, 1);
  type('F');
  EXPECT_EQ(desk.n.up, glm::dvec3(0, 1, 0));
  type('o');
  EXPECT_TRUE(desk.n.drift);
  type('O');
  EXPECT_FALSE(desk.n.drift);
  type('r');
  EXPECT_TRUE(desk.n.transition);
  desk.tell({.kind = Kind::scrolled, .position = {320, 240}, .amount = 1});
  EXPECT_FALSE(desk.n.transition);
  EXPECT_NEAR(desk.n.view.distance, 5 / 1.15, 1e-9);
}

TEST(InitialView, IsTheViewInTheMiddleOfTheOthers) {
  std::vector<View> views;
  for (const double x : {-3.0, -1.0, 0.5, 2.0, 9.0})
    views.emplace_back().camera = test::camera_at({x, 0, -5}, {0, 0, 0}, 64, 48);
  EXPECT_LT(glm::distance(cli::initial_view_of(views).position, glm::dvec3(0.5, 0, -5)), 1e-9);
}

TEST(InitialView, UpIsWhatIsGivenOrWhatTheViewsSay) {
  EXPECT_EQ(**cli::parse_up("0,0,2"), glm::dvec3(0, 0, 1));
  EXPECT_FALSE(*cli::parse_up("auto"));
  SceneFile scene;
  scene.cloud = test::random_cloud(200, 0);
  Dataset data;
  data.train.emplace_back().camera = test::camera_at({3, 0, 0}, {0, 0, 0}, 64, 48);
  data.train.emplace_back().camera = test::camera_at({0, 0, 3}, {0, 0, 0}, 64, 48);
  const auto start = cli::initial_navigation(scene.cloud, scene.start, data, std::nullopt,
                                             std::nullopt, {640, 480});
  EXPECT_LT(glm::distance(start.navigation.up, glm::dvec3(0, -1, 0)), 0.02);
  EXPECT_LT(glm::distance(camera::eye(start.navigation.view), glm::dvec3(3, 0, 0)), 1e-9);
  EXPECT_LT(glm::length(start.navigation.view.target), 0.01);
  const auto given = cli::initial_navigation(scene.cloud, scene.start, data, std::nullopt,
                                             glm::dvec3(0, 0, 1), {640, 480});
  EXPECT_EQ(given.navigation.up, glm::dvec3(0, 0, 1));
  scene.start = {.position = {0, 0, -4}, .fov_y = 1, .up = {1, 0, 0}};
  const auto views_first = cli::initial_navigation(scene.cloud, scene.start, data, std::nullopt,
                                                   std::nullopt, {640, 480});
  EXPECT_EQ(views_first.navigation.view.target, start.navigation.view.target);
  const auto own = cli::initial_navigation(scene.cloud, scene.start, std::nullopt, std::nullopt,
                                           std::nullopt, {640, 480});
  EXPECT_EQ(own.navigation.up, glm::dvec3(1, 0, 0));
  EXPECT_LT(glm::distance(camera::eye(own.navigation.view), glm::dvec3(0, 0, -4)), 1e-9);
  EXPECT_EQ(own.navigation.view.fov, 1);
}

}  // namespace
}  // namespace fluxgs
