// One image of a scene, drawn off the screen from where the scene asks to be looked at: to
// compare processors. Usage: render_once SCENE WIDTHxHEIGHT OUT.ppm; says which driver it was.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "camera/initial_view.h"
#include "fluxgs/io/scene.h"
#include "platform/host/host_context.h"
#include "render/renderer.h"

namespace fluxgs {
namespace {

template <class T>
T expect(Expected<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "render_once: error: %s\n", result.error().message().c_str());
  std::exit(1);
}

void expect(Expected<void> result) {
  if (result) return;
  std::fprintf(stderr, "render_once: error: %s\n", result.error().message().c_str());
  std::exit(1);
}

Image<float> draw(const std::string& file, int width, int height) {
  const SceneFile scene = expect(read_scene(std::filesystem::path(file)));
  const auto context = expect(host::HostContext::create(host::HostGl::egl));
  std::fprintf(stderr, "%s\n", context->renderer_string().c_str());
  const auto renderer = expect(render::Renderer::create(context->api()));
  expect(renderer->upload(scene.cloud));
  const auto target = expect(
      render::RenderTarget::create(context->api(), width, height, render::TargetFormat::rgba8));
  const camera::Navigation first =
      camera::initial_navigation(scene.cloud, scene.start, glm::dvec2(width, height));
  RenderOptions options;
  options.near_plane = first.units.near_plane;
  expect(renderer->draw(camera::camera_of(first.view, width, height), options, target));
  return expect(renderer->read(target));
}

void write_ppm(const Image<float>& image, const char* file) {
  std::ofstream out(file, std::ios::binary);
  out << "P6\n" << image.width << ' ' << image.height << "\n255\n";
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        out.put(static_cast<char>(std::lround(255 * std::clamp(image.at(x, y)[c], 0.0F, 1.0F))));
}

}  // namespace
}  // namespace fluxgs

int main(int count, char** arguments) {
  int width = 0, height = 0;
  if (count != 4 || std::sscanf(arguments[2], "%dx%d", &width, &height) != 2) {
    std::fputs("usage: render_once SCENE WIDTHxHEIGHT OUT.ppm\n", stderr);
    return 2;
  }
  fluxgs::write_ppm(fluxgs::draw(arguments[1], width, height), arguments[3]);
}
