// Pairs of photos that are compared.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "trainer/core/progress.h"
#include "trainer/data/photos/prepare_photos.h"

namespace fluxgs {

/// Photos up to this number are all compared with each other.
inline constexpr std::size_t kMostForAllPairs = 40;

/// Pairs of indices (i < j) of photos that may show the same things, at most some 26 a photo: those
/// taken one after the other, those that look alike, and those near each other by GPS. Sorted by
/// j − i, so that neighbours come first. The same for the same photos.
///
/// Looks are compared by VLAD descriptors (Jégou et al. 2010) of SIFT features on copies of 480
/// pixels, with a vocabulary of 32 words learned from these photos. `folder` holds the copies; one
/// that cannot be read looks like no other.
std::vector<std::pair<int, int>> match_pairs(const std::vector<PreparedPhoto>& photos,
                                             const std::filesystem::path& folder,
                                             const StepReport& report);

}  // namespace fluxgs
