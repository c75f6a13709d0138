// make_capture: images with known poses, made by ray-tracing, for the quickstart and the tests.
#include <cstdio>
#include <exception>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include "tools/capture/capture.h"

namespace {

const std::map<std::string, fluxgs::capture::SceneKind> kScenes{
    {"spheres", fluxgs::capture::SceneKind::kSpheres},
    {"outdoor", fluxgs::capture::SceneKind::kOutdoor},
    {"room", fluxgs::capture::SceneKind::kRoom},
    {"wall", fluxgs::capture::SceneKind::kWall}};

/// "320x240"; false if it is anything else.
bool parse_size(const std::string& text, fluxgs::capture::CaptureOptions& options) {
  char rest = 0;
  return std::sscanf(text.c_str(), "%dx%d%c", &options.width, &options.height, &rest) == 2;
}

int run(int argc, char** argv) {
  fluxgs::capture::CaptureOptions options;
  std::string folder, size = "320x240", scene = "spheres";
  CLI::App app{
      "Ray-trace a small posed image set in the layout of the NeRF-synthetic scenes (train/, "
      "test/, "
      "transforms_train.json, transforms_test.json).\n\n"
      "Scenes: glossy spheres on a marble floor; outdoors, with bushes near and hills and clouds "
      "far "
      "away; a room from inside, with white walls; a wall of bricks that is all fine texture, seen "
      "from the front."};
  app.footer(
      "Examples:\n"
      "  make_capture captures/spheres --size 320x240 --train 40 --test 8\n"
      "  make_capture captures/room --scene room --size 400x266 --train 100 --samples 2");
  app.add_option("OUT_DIR", folder, "Folder to write to; created if missing")->required();
  app.add_option("--scene", scene, "What is seen")
      ->check(CLI::IsMember(kScenes))
      ->capture_default_str();
  app.add_option("--size", size, "Pixels of each image, WxH")->capture_default_str();
  app.add_option("--train", options.train, "Training views")->capture_default_str();
  app.add_option("--test", options.test, "Test views")->capture_default_str();
  app.add_option("--seed", options.seed, "Seed of poses and textures")->capture_default_str();
  app.add_flag("--occluder", options.occluder,
               "Something moves through the training views; masks/train/ shows where");
  app.add_option("--points", options.points,
                 "So many points on the surfaces, which a training then begins with")
      ->capture_default_str();
  app.add_option("--samples", options.samples, "NxN rays a pixel")->capture_default_str();
  try {
    app.parse(argc, argv);
    if (!parse_size(size, options)) throw CLI::ValidationError("--size", "expected WxH");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  options.scene = kScenes.at(scene);
  if (const auto ok = fluxgs::capture::write_capture(folder, options); !ok) {
    std::fprintf(stderr, "make_capture: error: %s\n", ok.error().message().c_str());
    return 1;
  }
  std::fprintf(stderr, "%s: %d training and %d test views of %dx%d\n", folder.c_str(),
               options.train, options.test, options.width, options.height);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {  // Out of memory, at most
    std::fprintf(stderr, "make_capture: error: %s\n", error.what());
    return 1;
  }
}
