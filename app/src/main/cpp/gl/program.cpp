#include "gl/program.h"

#include <array>
#include <vector>

#include "gl/shader_log.h"

namespace fluxgs::gl {
namespace {

void destroy_shader(Api& api, GLuint name) { api.DeleteShader(name); }
using Shader = Handle<destroy_shader>;

// The #version directive must stay the first line (GLSL ES 3.10, section 3.4).
std::string with_defines(std::string_view source, std::span<const std::string> defines,
                         bool compute) {
  const std::size_t first_line = source.find('\n') + 1;
  std::string text(compute ? source.substr(0, first_line) : "#version 300 es\n");
  for (const std::string& define : defines) text += "#define " + define + "\n";
  text += "#line 2\n";
  return text.append(source.substr(first_line));
}

std::string one_line(std::string log) {
  while (!log.empty() && (log.back() == '\n' || log.back() == '\0' || log.back() == ' '))
    log.pop_back();
  for (char& c : log)
    if (c == '\n') c = ';';
  return log.empty() ? "the driver gave no reason" : log;
}

std::string shader_log(Api& api, GLuint shader) {
  GLint length = 0;
  api.GetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length > 0 ? length : 0), '\0');
  if (length > 0) api.GetShaderInfoLog(shader, length, nullptr, log.data());
  return log;
}

std::string program_log(Api& api, GLuint program) {
  GLint length = 0;
  api.GetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length > 0 ? length : 0), '\0');
  if (length > 0) api.GetProgramInfoLog(program, length, nullptr, log.data());
  return one_line(std::move(log));
}

std::string stage_name(GLenum stage) {
  switch (stage) {
    case GL_VERTEX_SHADER:
      return "vertex";
    case GL_FRAGMENT_SHADER:
      return "fragment";
    case GL_COMPUTE_SHADER:
      return "compute";
    default:
      return "unknown";
  }
}

Expected<Shader> compile(Api& api, const ShaderSource& source,
                         std::span<const std::string> defines) {
  Shader shader(api, api.CreateShader(source.stage));
  const std::string text = with_defines(source.text, defines, api.capabilities.compute);
  const char* pointer = text.c_str();
  api.ShaderSource(shader.name(), 1, &pointer, nullptr);
  api.CompileShader(shader.name());
  GLint ok = GL_FALSE;
  api.GetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  return fail(stage_name(source.stage) + " shader " + std::string(source.name), "compile",
              one_line(name_lines(shader_log(api, shader.name()), source.name, text)));
}

}  // namespace

Expected<Program> Program::create(Api& api, std::span<const ShaderSource> stages,
                                  std::span<const std::string> defines) {
  Program program;
  program.handle_ = {api, api.CreateProgram()};
  std::vector<Shader> shaders;
  std::string names;
  for (const ShaderSource& stage : stages) {
    auto shader = compile(api, stage, defines);
    if (!shader) return std::unexpected(shader.error());
    api.AttachShader(program.handle_.name(), shader->name());
    shaders.push_back(std::move(*shader));
    names += (names.empty() ? "" : " + ") + std::string(stage.name);
  }
  api.LinkProgram(program.handle_.name());
  GLint ok = GL_FALSE;
  api.GetProgramiv(program.handle_.name(), GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE)
    return fail("shader " + names, "link", program_log(api, program.handle_.name()));
  const GLuint frame = api.GetUniformBlockIndex(program.handle_.name(), "Frame");
  if (frame != GL_INVALID_INDEX) api.UniformBlockBinding(program.handle_.name(), frame, 0);
  return program;
}

void Program::set_sampler(const char* name, GLint unit) const {
  use();
  handle_.api().Uniform1i(uniform(name), unit);
}

}  // namespace fluxgs::gl
