#include "tools/fluxgs/write_glb.h"

#include "fluxgs/io/file.h"

namespace fluxgs::cli {

Expected<std::size_t> write_glb(const std::filesystem::path& path,
                                const std::vector<std::byte>& glb,
                                const std::optional<InitialView>& initial) {
  const auto file = initial ? with_initial_view(glb, *initial, path.string())
                            : Expected<std::vector<std::byte>>(glb);
  if (!file) return std::unexpected(file.error());
  if (auto written = write_file_atomic(path, *file); !written)
    return std::unexpected(written.error());
  return file->size();
}

}  // namespace fluxgs::cli
