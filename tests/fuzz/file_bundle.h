// Several named files in one string of bytes, made so that a fuzzer can move their borders: each
// begins with a line "\n#FILE NAME\n" and ends where the next begins.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <string_view>

#include "harness.h"

namespace fluxgs::fuzz {

inline constexpr std::string_view kFileMark = "\n#FILE ";

using Files = std::map<std::string, Bytes>;  ///< name → content

inline Bytes bundle_of(const Files& files) {
  Bytes bundle;
  const auto put = [&](std::string_view text) {
    const auto* raw = reinterpret_cast<const std::byte*>(text.data());
    bundle.insert(bundle.end(), raw, raw + text.size());
  };
  for (const auto& [name, content] : files) {
    put(kFileMark);
    put(name);
    put("\n");
    bundle.insert(bundle.end(), content.begin(), content.end());
  }
  return bundle;
}

/// Of files of the same name the last counts. What stands before the first mark is no file.
inline Files files_of(Input bundle) {
  const std::string_view text(reinterpret_cast<const char*>(bundle.data()), bundle.size());
  Files files;
  for (std::size_t at = text.find(kFileMark); at != text.npos;) {
    const std::size_t name = at + kFileMark.size();
    const std::size_t end = std::min(text.find('\n', name), text.size());
    const std::size_t content = std::min(end + 1, text.size());
    at = text.find(kFileMark, end);
    const Input bytes =
        bundle.subspan(content, std::max(std::min(at, text.size()), content) - content);
    files[std::string(text.substr(name, end - name))] = Bytes(bytes.begin(), bytes.end());
  }
  return files;
}

}  // namespace fluxgs::fuzz
