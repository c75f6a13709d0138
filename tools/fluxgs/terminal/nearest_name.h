// Suggestions for misspelled names.
#pragma once

#include <string>
#include <vector>

namespace fluxgs::cli {

/// The name with the fewest letters inserted, deleted, replaced or swapped; empty if none is near.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace fluxgs::cli
