#include "gl/framebuffer.h"

#include <string>

namespace fluxgs::gl {

Expected<Framebuffer> Framebuffer::create(Api& api, const Texture& color, const Texture* depth) {
  GLuint name = 0;
  api.GenFramebuffers(1, &name);
  Framebuffer framebuffer;
  framebuffer.handle_ = {api, name};
  framebuffer.bind();
  api.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color.name(), 0);
  if (depth)
    api.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->name(), 0);
  const GLenum status = api.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return framebuffer;
  return fail("OpenGL", "framebuffer",
              "the driver cannot render to this format (status " + std::to_string(status) + ")");
}

}  // namespace fluxgs::gl
