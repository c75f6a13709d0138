// A linked shader program.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "gl/handle.h"

namespace fluxgs::gl {

/// The source of one stage.
struct ShaderSource {
  GLenum stage = 0;
  std::string_view name;  ///< for error texts: the file's name
  std::string_view text;
};

class Program {
 public:
  Program() = default;

  /// Compiles and links. `defines` ("NAME VALUE" each) go right after the #version line. The error
  /// names the stage and the file, and holds the driver's log with the files' own lines
  /// (gl/shader_log.h). The uniform block Frame, if there is one, is that at binding 0. Without
  /// compute shaders (Capabilities::compute) the text says `#version 300 es` in place of 310.
  static Expected<Program> create(Api& api, std::span<const ShaderSource> stages,
                                  std::span<const std::string> defines = {});

  void use() const { handle_.api().UseProgram(handle_.name()); }

  /// The place of a uniform, for glUniform…; -1 where the linker left it out.
  GLint uniform(const char* name) const {
    return handle_.api().GetUniformLocation(handle_.name(), name);
  }
  /// The sampler reads that texture unit from now on.
  void set_sampler(const char* name, GLint unit) const;

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteProgram(name); }
  Handle<destroy> handle_;
};

}  // namespace fluxgs::gl
