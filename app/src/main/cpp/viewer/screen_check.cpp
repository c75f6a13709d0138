#include "viewer/screen_check.h"

#include <cstdint>

#include <webp/decode.h>

#include "bench/driver_check.h"
#include "camera/initial_view.h"
#include "fluxgs/io/scene.h"

namespace fluxgs::viewer {
namespace {

Expected<Image<std::uint8_t>> read_golden(std::span<const std::byte> bytes) {
  constexpr int kMaxSide = 1024;
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  int width = 0, height = 0;
  if (WebPGetInfo(data, bytes.size(), &width, &height) == 0 || width > kMaxSide ||
      height > kMaxSide)
    return fail("golden picture", "", "expected a WebP image of at most 1024x1024 pixels");
  Image<std::uint8_t> image(width, height, 3);
  if (WebPDecodeRGBInto(data, bytes.size(), image.pixels.data(), image.pixels.size(), 3 * width) ==
      nullptr)
    return fail("golden picture", "", "is a damaged WebP image");
  return image;
}

}  // namespace

Expected<std::string> check_driver_of(Screen& screen, std::span<const std::byte> scene,
                                      std::span<const std::byte> golden, const std::string& known) {
  const auto made = screen.make_context();
  if (!made) return std::unexpected(made.error());
  gl::Api& api = **made;
  if (api.capabilities.renderer + ", " + api.capabilities.version == known) return std::string();
  const auto picture = read_golden(golden);
  if (!picture) return std::unexpected(picture.error());
  const auto file = read_scene(scene, "scene of the driver check");
  if (!file) return std::unexpected(file.error());
  const camera::Navigation from =
      camera::initial_navigation(file->cloud, file->start, {picture->width, picture->height});
  gl::hook_debug_messages(api);
  const auto check = bench::check_driver(
      api, file->cloud, camera::camera_of(from.view, picture->width, picture->height),
      from.units.near_plane, *picture);
  if (api.DebugMessageCallback) api.Disable(GL_DEBUG_OUTPUT_KHR);  // it makes frames slower
  return bench::to_json(check, api);
}

}  // namespace fluxgs::viewer
