#include "gl/framebuffer.h"

#include <string>
#include <vector>

namespace fluxgs::gl {

Expected<Framebuffer> Framebuffer::create(Api& api, const Texture& color, const Texture* depth) {
  const Texture* const colors[] = {&color};
  return create(api, colors, depth);
}

Expected<Framebuffer> Framebuffer::create(Api& api, std::span<const Texture* const> colors,
                                          const Texture* depth) {
  GLuint name = 0;
  api.GenFramebuffers(1, &name);
  Framebuffer framebuffer;
  framebuffer.handle_ = {api, name};
  framebuffer.bind();
  std::vector<GLenum> attachments;
  for (const Texture* color : colors) {
    attachments.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(attachments.size()));
    api.FramebufferTexture2D(GL_FRAMEBUFFER, attachments.back(), GL_TEXTURE_2D, color->name(), 0);
  }
  if (attachments.size() > 1)
    api.DrawBuffers(static_cast<GLsizei>(attachments.size()), attachments.data());
  if (depth)
    api.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->name(), 0);
  const GLenum status = api.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return framebuffer;
  return fail("OpenGL", "framebuffer",
              "the driver cannot render to this format (status " + std::to_string(status) + ")");
}

}  // namespace fluxgs::gl
