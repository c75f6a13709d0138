// Sharp frames of a video, by ffmpeg.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/progress.h"

namespace fluxgs {

inline constexpr int kDefaultVideoFrames = 150;

/// Writes at most `count` frames of a video as frame_00001.jpg … into `folder`, which appears
/// complete or not at all. The video is cut into `count` parts of the same length, and the sharpest
/// frame of each is taken: the one with the largest variance of the Laplacian. Frames are turned as
/// the video's metadata say. Errors: ffmpeg is missing or fails, no video in the file, one frame.
Expected<void> extract_video_frames(const std::filesystem::path& video, int count,
                                    const std::filesystem::path& folder, const StepReport& report,
                                    std::vector<std::string>& warnings);

/// Index of the sharpest frame of each of `count` parts of equal length; all frames where there are
/// no more than that.
std::vector<std::size_t> sharpest_frames(std::span<const double> sharpness, std::size_t count);

}  // namespace fluxgs
