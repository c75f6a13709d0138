// The images that are kept for testing.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"
#include "trainer/data/dataset.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Moves the frames for testing to Source::test_frames and sorts both lists by name:
///   - those of LoadOptions::test_list or each n-th of LoadOptions::test_every, where given;
///   - otherwise as the data set says: Source::has_split, Source::split, or lists of names in its
///     folder (train_test_split.json, train_test_lists.json, train.txt and test.txt,
///     train_list.txt and test_list.txt, sparse/0/test.txt), images of neither list left out;
///   - otherwise every eighth.
/// A single frame stays. Names match with or without folders and extensions. Errors: a test_list
/// that cannot be read or names no image.
Expected<void> hold_out(Source& source, const std::filesystem::path& folder,
                        const LoadOptions& options);

}  // namespace fluxgs
