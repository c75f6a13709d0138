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

}  // namespace fluxgs
