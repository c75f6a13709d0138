// Tiny data sets on disk for the loader's tests.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fluxgs/error.h"
#include "fluxgs/image.h"
#include "trainer/data/image_io.h"

namespace fluxgs::test {

namespace fs = std::filesystem;

/// A folder that goes away with the object.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (fs::temp_directory_path() / "fluxgs-data-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

inline void write_text(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

inline std::string read_all(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline void remove_file(const fs::path& file) { fs::remove(file); }

/// A smooth image that no two sizes and phases share.
inline Image<std::uint8_t> pattern(int width, int height, int channels = 3, int phase = 0) {
  Image<std::uint8_t> image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>((7 * x + 5 * y + 60 * c + 11 * phase) % 256);
  return image;
}

inline void write_image(const fs::path& file, const Image<std::uint8_t>& image) {
  fs::create_directories(file.parent_path());
  ASSERT_TRUE(write_png(file, image)) << file;
}

/// Matches a failed Expected whose one-line message contains all of the texts.
template <class T, class... Text>
void expect_failure(const Expected<T>& result, const Text&... texts) {
  ASSERT_FALSE(result.has_value());
  const std::string message = result.error().message();
  EXPECT_THAT(message, testing::AllOf(testing::HasSubstr(texts)...));
  EXPECT_EQ(message.find('\n'), std::string::npos) << "one line expected: " << message;
}

/// Appends the bytes of values, as COLMAP's binary files hold them.
class Bytes {
 public:
  template <class T>
  Bytes& add(T value) {
    const auto at = text.size();
    text.resize(at + sizeof(T));
    std::memcpy(text.data() + at, &value, sizeof(T));
    return *this;
  }
  Bytes& add_name(const std::string& name) {
    text += name;
    text += '\0';
    return *this;
  }
  std::string text;
};

}  // namespace fluxgs::test
