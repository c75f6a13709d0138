#include "gl/texture.h"

#include <string>

namespace fluxgs::gl {

Expected<Texture> Texture::create(Api& api, GLenum format, int width, int height) {
  GLuint name = 0;
  api.GenTextures(1, &name);
  Texture texture;
  texture.handle_ = {api, name};
  texture.bind(0);
  clear_errors(api);
  api.TexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  const std::string where =
      "texture of " + std::to_string(width) + "×" + std::to_string(height) + " pixels";
  if (auto ok = check_errors(api, where.c_str()); !ok) return std::unexpected(ok.error());
  api.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  api.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

void Texture::bind(GLuint unit) const {
  handle_.api().ActiveTexture(GL_TEXTURE0 + unit);
  handle_.api().BindTexture(GL_TEXTURE_2D, name());
}

}  // namespace fluxgs::gl
