#include "trainer/data/file_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fluxgs/sanitize.h"

namespace fluxgs {

void FileList::add(const std::string& file) {
  constexpr std::size_t kNamed = 3;
  if (count_++ < kNamed) first_.push_back(one_line(file));
}

std::string FileList::text() const {
  const std::string named = fmt::format("{}", fmt::join(first_, ", "));
  return count_ == first_.size() ? named
                                 : fmt::format("{} and {} more", named, count_ - first_.size());
}

void FailedImages::add(const std::string& file, const Error& error) {
  if (files_.empty()) first_error_ = error, first_ = file;
  files_.add(file);
}

void FailedImages::warn(std::vector<std::string>& warnings) const {
  if (files_.size() == 1)
    warnings.push_back(fmt::format("{}; {} is left out", first_error_.message(),
                                   first_error_.file == first_ ? "it" : one_line(first_)));
  else if (!files_.empty())
    warnings.push_back(fmt::format("{} images are left out: {}; the first: {}", files_.size(),
                                   files_.text(), first_error_.message()));
}

std::unexpected<Error> FailedImages::failure(std::size_t all) const {
  if (files_.size() == 1) return std::unexpected(first_error_);
  return fail("", "",
              fmt::format("{} of {} images cannot be used: {}; the first: {}", files_.size(), all,
                          files_.text(), first_error_.message()));
}

}  // namespace fluxgs
