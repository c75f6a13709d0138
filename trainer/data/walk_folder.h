// A bounded walk through a folder and what lies below it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <system_error>

namespace fluxgs {

/// Calls visit(entry, depth) for each entry below a folder, at most a million of them; `depth` is 0
/// in the folder itself. Goes into those folders for which it returns true. What cannot be read is
/// passed over; links to folders are not followed.
template <class Visit>
void walk_folder(const std::filesystem::path& folder, const Visit& visit) {
  namespace fs = std::filesystem;
  constexpr std::size_t kMost = 1'000'000;
  std::error_code error;
  const auto options = fs::directory_options::skip_permission_denied;
  std::size_t count = 0;
  for (fs::recursive_directory_iterator at(folder, options, error), end;
       !error && at != end && count < kMost; at.increment(error), ++count)
    if (!visit(*at, at.depth())) at.disable_recursion_pending();
}

}  // namespace fluxgs
