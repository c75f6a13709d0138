// Helpers of the tests of scene formats.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "fluxgs/error.h"
#include "tests/support/scenes.h"

namespace fluxgs::test {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::string_view text) {
  Bytes bytes(text.size());
  if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}
inline std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
template <class T>
void append(Bytes& bytes, const T& value) {
  const auto* raw = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), raw, raw + sizeof value);
}

/// A folder of its own for each test, removed afterwards.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    static std::atomic<int> counter{0};
    path_ = std::filesystem::temp_directory_path() /
            ("fluxgs-test-" + std::to_string(::getpid()) + "-" + std::to_string(counter++));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

/// A file of the real data, if the variable FLUXGS_DATA says where they are.
inline std::optional<std::filesystem::path> data_file(const std::string& relative) {
  const char* root = std::getenv("FLUXGS_DATA");
  if (root == nullptr) return std::nullopt;
  auto path = std::filesystem::path(root) / relative;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path;
}

/// Fails unless `result` is an error whose one-line message has all of `parts`.
template <class T>
void expect_error(const Expected<T>& result, std::initializer_list<std::string_view> parts) {
  ASSERT_FALSE(result.has_value()) << "expected an error with " << *parts.begin();
  const std::string message = result.error().message();
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  for (const std::string_view part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "no \"" << part << "\" in: " << message;
  }
}

}  // namespace fluxgs::test

/// Unwrap an Expected or end the test with its message.
#define FLUXGS_UNWRAP(variable, expression)                                  \
  auto variable##_or = (expression);                                         \
  ASSERT_TRUE(variable##_or.has_value()) << variable##_or.error().message(); \
  auto& variable = *variable##_or  // NOLINT(bugprone-macro-parentheses): a name
