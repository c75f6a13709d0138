// Files that one warning speaks of.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace fluxgs {

class FileList {
 public:
  void add(const std::string& file);
  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// "a.jpg", "a.jpg, b.jpg", "a.jpg, b.jpg, c.jpg and 4 more".
  std::string text() const;

 private:
  std::vector<std::string> first_;
  std::size_t count_ = 0;
};

}  // namespace fluxgs
