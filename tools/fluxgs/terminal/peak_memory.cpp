#include "tools/fluxgs/terminal/peak_memory.h"

#include <fstream>
#include <string>

namespace fluxgs::cli {

// Not getrusage(), which also counts what the parent held when it started this program
std::size_t peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::size_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * 1024;
  }
  return 0;
}

}  // namespace fluxgs::cli
