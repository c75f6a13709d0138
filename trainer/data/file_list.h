// Files that one warning speaks of.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fluxgs/error.h"

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

/// Images that failed, and why the first one did.
class FailedImages {
 public:
  void add(const std::string& file, const Error& error);
  std::size_t size() const { return files_.size(); }
  /// Adds one line to the warnings, if any image failed.
  void warn(std::vector<std::string>& warnings) const;
  /// The error of a set of `all` images with too many of these: that of the image, if it is one.
  std::unexpected<Error> failure(std::size_t all) const;

 private:
  FileList files_;
  std::string first_;
  Error first_error_;
};

}  // namespace fluxgs
