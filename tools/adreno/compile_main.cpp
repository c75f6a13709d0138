// adreno_statistics FOLDER: compiles every program of the folder (NAME.comp, or NAME.vert with
// NAME.frag) with the OpenGL driver that EGL finds, and writes what the driver says of each.
// Started by tools/adreno/report with Mesa's driver for Adreno, whose statistics come as messages
// of KHR_debug and whose shared memory sizes come on standard error, hence in order with these.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "fluxgs/io/file.h"
#include "gl/program.h"
#include "platform/host/host_context.h"

namespace fluxgs::adreno {
namespace {

namespace fs = std::filesystem;

struct Stage {
  const char* extension;
  GLenum type;
};
constexpr std::array kStages = {Stage{".comp", GL_COMPUTE_SHADER}, Stage{".vert", GL_VERTEX_SHADER},
                                Stage{".frag", GL_FRAGMENT_SHADER}};

Expected<std::vector<std::string>> program_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() != ".frag") names.push_back(entry.path().stem().string());
  if (error) return fail(folder.string(), "", "cannot be read: " + error.message());
  if (names.empty()) return fail(folder.string(), "", "holds no programs");
  std::ranges::sort(names);
  return names;
}

Expected<void> compile(gl::Api& api, const fs::path& folder, const std::string& name) {
  std::vector<std::string> texts, files;
  std::vector<GLenum> types;
  for (const Stage& stage : kStages) {
    const fs::path file = folder / (name + stage.extension);
    if (!fs::exists(file)) continue;
    const auto bytes = read_file(file);
    if (!bytes) return std::unexpected(bytes.error());
    texts.emplace_back(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    files.push_back(file.filename().string());
    types.push_back(stage.type);
  }
  std::vector<gl::ShaderSource> stages;
  for (std::size_t i = 0; i < texts.size(); ++i) stages.push_back({types[i], files[i], texts[i]});
  api.debug.messages.clear();
  const auto program = gl::Program::create(api, stages);
  if (!program) return std::unexpected(program.error());
  api.Finish();
  for (const gl::DebugMessage& message : api.debug.messages)
    std::printf("message: %s\n", message.text.c_str());
  return {};
}

Expected<void> run(const fs::path& folder) {
  const auto names = program_names(folder);
  if (!names) return std::unexpected(names.error());
  const auto context = host::HostContext::create(host::HostGl::egl);
  if (!context) return std::unexpected(context.error());
  gl::Api& api = (*context)->api();
  std::printf("driver: %s\nversion: %s\n", api.capabilities.renderer.c_str(),
              api.capabilities.version.c_str());
  if (!api.capabilities.debug) return fail(api.capabilities.renderer, "KHR_debug", "is missing");
  for (const std::string& name : *names) {
    std::printf("program: %s\n", name.c_str());
    std::fflush(stdout);
    if (auto ok = compile(api, folder, name); !ok) return ok;
  }
  return {};
}

}  // namespace
}  // namespace fluxgs::adreno

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: adreno_statistics FOLDER    # see tools/adreno/report\n", stderr);
    return 2;
  }
  const auto done = fluxgs::adreno::run(argv[1]);
  if (!done) std::fprintf(stderr, "adreno: error: %s\n", done.error().message().c_str());
  return done ? 0 : 1;
}
