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
  /// (gl/shader_log.h).
  static Expected<Program> create(Api& api, std::span<const ShaderSource> stages,
                                  std::span<const std::string> defines = {});

  void use() const { handle_.api().UseProgram(handle_.name()); }

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteProgram(name); }
  Handle<destroy> handle_;
};

}  // namespace fluxgs::gl
