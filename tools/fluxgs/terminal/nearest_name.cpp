#include "tools/fluxgs/terminal/nearest_name.h"

#include <algorithm>
#include <cstddef>

namespace fluxgs::cli {
namespace {

/// Damerau-Levenshtein distance (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before.swap(last);
    last.swap(row);
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_name(const std::string& word, const std::vector<std::string>& names) {
  std::string best;
  std::size_t least = word.size() / 3 + 1;  // more differences are another word
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < least || (distance == least && best.empty())) best = name, least = distance;
  }
  return best;
}

}  // namespace fluxgs::cli
