// What the tests of the scene formats share.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"

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

/// Plausible splats, the same for the same seed.
inline SplatCloud random_cloud(std::size_t count, int sh_degree, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto vec = [&](float scale) {
    return glm::vec3(normal(random), normal(random), normal(random)) * scale;
  };
  SplatCloud cloud;
  cloud.sh_degree = sh_degree;
  cloud.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions[i] = vec(3);
    cloud.log_scales[i] = vec(1.5f) - glm::vec3(4);
    cloud.rotations[i] = glm::quat(normal(random), normal(random), normal(random), normal(random));
    cloud.opacity_logits[i] = 3 * normal(random);
    cloud.sh_dc[i] = vec(1);
  }
  for (glm::vec3& c : cloud.sh_rest) c = vec(0.3f);
  return cloud;
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
