// Runs the command as people do.
#pragma once

#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "support/temp_folder.h"

namespace fluxgs::test {

struct Outcome {
  int status;
  std::string out, err;
};

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The path of the program under test.
extern const char* const kFluxgs;

/// Runs `fluxgs ARGUMENTS` in a shell, after `before` (limits, say).
inline Outcome fluxgs(const std::string& arguments, const std::string& before = "") {
  const test::TempFolder folder;
  const std::string command = fmt::format("{} '{}' {} >'{}' 2>'{}'", before, kFluxgs, arguments,
                                          (folder / "out").string(), (folder / "err").string());
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(folder / "out"),
          text_of(folder / "err")};
}

/// The command failed as it should: status 1, nothing on standard output, a last line that says
/// "fluxgs: error: " and has all of `parts`.
inline void expect_error(const Outcome& o, const std::vector<std::string>& parts) {
  EXPECT_EQ(o.status, 1) << o.err;
  EXPECT_EQ(o.out, "");
  const std::size_t at = o.err.rfind("fluxgs: error: ");
  ASSERT_NE(at, std::string::npos) << o.err;
  const std::string line = o.err.substr(at);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
  for (const std::string& part : parts)
    EXPECT_NE(line.find(part), std::string::npos) << part << " in: " << line;
}

inline std::string quoted(const std::filesystem::path& path) {
  return fmt::format("'{}'", path.string());
}

/// Number of files and folders in a folder.
inline std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                                std::filesystem::directory_iterator()));
}

}  // namespace fluxgs::test
