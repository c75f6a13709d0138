// Writes the seeds: make_seeds FOLDER makes FOLDER/TARGET/NAME for every target. Real scenes are
// among them if FLUXGS_DATA names a folder with some.
#include <cstdio>

#include "fluxgs/io/file.h"
#include "seeds.h"

int main(int count, char** arguments) {
  using namespace fluxgs;
  if (count != 2) {
    std::fprintf(stderr, "usage: make_seeds FOLDER\n");
    return 2;
  }
  const fuzz::Seeds seeds = fuzz::make_seeds();
  std::size_t written = 0;
  for (const auto& [target, inputs] : seeds) {
    const auto folder = std::filesystem::path(arguments[1]) / target;
    std::filesystem::create_directories(folder);
    for (const auto& [name, bytes] : inputs) {
      const auto done = write_file_atomic(folder / name, bytes);
      if (!done) {
        std::fprintf(stderr, "make_seeds: error: %s\n", done.error().message().c_str());
        return 1;
      }
      ++written;
    }
  }
  std::printf("%zu seeds for %zu targets\n", written, seeds.size());
  return 0;
}
