#include "tools/fluxgs/work_folder.h"

#include <cstdlib>
#include <string>
#include <system_error>

namespace fluxgs::cli {

namespace fs = std::filesystem;

WorkFolder::WorkFolder() {
  std::error_code ignored;
  std::string pattern = (fs::temp_directory_path(ignored) / "fluxgs-XXXXXX").string();
  if (mkdtemp(pattern.data()) != nullptr) path_ = pattern;
}

WorkFolder::~WorkFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace fluxgs::cli
