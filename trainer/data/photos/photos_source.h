// Photos without poses, or a video, as a data set.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/progress.h"
#include "trainer/data/source.h"

namespace fluxgs {

struct PhotosSource {
  std::string kind;  ///< "images (COLMAP)" or "video (COLMAP)"
  Source source;
};

/// The photos of a folder (in images/ or itself, see list_photos) or `video_frames` frames of a
/// video (0: as before, or kDefaultVideoFrames), with poses that COLMAP finds. All work is done in
/// work_folder_of(input), kept there, and done once: a second call reads its result. Photos added
/// since are added; where a photo has changed everything is done again.
/// Photos without a pose are named in a warning. Errors: neither photos nor a video, fewer than two
/// photos, those of run_colmap() and extract_video_frames().
Expected<PhotosSource> read_photos_source(const std::filesystem::path& input, int video_frames,
                                          const StepReport& report);

/// True for a video, and for a folder that holds photos, a video, or folders of these.
bool holds_photos(const std::filesystem::path& input);

}  // namespace fluxgs
