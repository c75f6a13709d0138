// The image in the framebuffer of a window, whose row 0 is at the bottom.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "platform/host/window.h"

namespace fluxgs::host {

Expected<Image<std::uint8_t>> read_window(gl::Api& api, const WindowSize& size) {
  Image<std::uint8_t> image(size.width, size.height, 3);
  std::vector<std::uint8_t> rgba(4 * image.pixels.size() / 3);
  api.BindFramebuffer(GL_FRAMEBUFFER, 0);
  api.PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl::clear_errors(api);
  api.ReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  if (auto ok = gl::check_errors(api, "glReadPixels"); !ok) return std::unexpected(ok.error());
  const std::uint8_t* from = rgba.data();
  for (int y = size.height - 1; y >= 0; --y)
    for (int x = 0; x < size.width; ++x, from += 4) std::copy_n(from, 3, image.at(x, y));
  return image;
}

}  // namespace fluxgs::host
