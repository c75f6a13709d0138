#include "tools/fluxgs/options/data_options.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "tools/fluxgs/terminal/progress.h"
#include "trainer/data/photos/video_frames.h"
#include "trainer/data/reduction.h"
#include "trainer/model/whole_number.h"

namespace fluxgs::cli {

CLI::Validator in_range(double min, double max) {
  const std::string name = fmt::format("in [{} - {}]", min, max);
  return {[=](const std::string& text) {
            double value = 0;
            const bool number = CLI::detail::lexical_cast(text, value);
            if (number && value >= min && value <= max) return std::string();  // not for NaN
            return fmt::format("{} is not a number {}", text, name);
          },
          "FLOAT:" + name};
}

CLI::Validator whole_in(std::int64_t min, std::int64_t max) {
  return {[=](const std::string& text) {
            std::int64_t value = 0;
            const auto [end, error] =
                std::from_chars(text.data(), text.data() + text.size(), value);
            const bool number = error == std::errc() && end == text.data() + text.size();
            if (number && value >= min && value <= max) return std::string();
            return fmt::format("'{}': expected a whole number from {} to {}", text, min, max);
          },
          fmt::format("{} to {}", min, max)};
}

CLI::Validator amount_in(std::int64_t min, std::int64_t max, const std::string& unit) {
  return {[=](std::string& text) {
            std::string_view number = text;
            if (!unit.empty() && number.ends_with(unit)) number.remove_suffix(unit.size());
            const auto value = whole_number(number);
            if (!value || *value < static_cast<double>(min) || *value > static_cast<double>(max))
              return fmt::format(
                  "'{}': expected a whole number from {} to {}, such as 50000 or 50k{}", text, min,
                  max, unit);
            text = fmt::format("{:.0f}", *value);
            return std::string();
          },
          fmt::format("{} to {}", min, max)};
}

void add_background_option(CLI::App& command, std::vector<double>& background) {
  command.add_option("--background", background, "colour behind the scene, r,g,b in 0..1")
      ->delimiter(',')
      ->expected(3)
      ->check(in_range(0, 1));
}

void add_data_options(CLI::App& command, DataOptions& options) {
  command
      .add_option("--downscale", options.downscale,
                  fmt::format("reduce the images by this factor (default: that of a scene's "
                              "training where it is known, else only those above {} pixels, to "
                              "that size)",
                              kDefaultLongestSide))
      ->check(whole_in(1, 64));
  command.add_option("--holdout", options.holdout,
                     "images for testing: none, every-N, or a file of their names (default: as the "
                     "data set says, or every-8)");
  command
      .add_option("--video-frames", options.video_frames,
                  fmt::format("frames to take of a video (default: {}, or as many as before)",
                              kDefaultVideoFrames))
      ->check(whole_in(2, 2000));
  command
      .add_option("--photo-memory", options.photo_memory,
                  "MiB that pixels of photos may take; more of them lie in a temporary file "
                  "(default: half of what is free)")
      ->check(in_range(1, 1e9));
  add_background_option(command, options.background);
  command.add_option("--threads", options.threads, "0: all cores; does not change the result")
      ->check(whole_in(0, 1024))
      ->capture_default_str();
}

void add_masks_option(CLI::App& command, MaskUse& masks) {
  command
      .add_option_function<std::string>(
          "--masks",
          [&masks](const std::string& name) {
            masks = static_cast<MaskUse>(std::ranges::find(kMaskUseNames, name) -
                                         kMaskUseNames.begin());
          },
          "what black in masks and transparency of photos mean (auto: ignore what is black; "
          "what is transparent shows the background)")
      ->check(CLI::IsMember(std::vector<std::string>(kMaskUseNames.begin(), kMaskUseNames.end())))
      ->default_str(std::string(kMaskUseNames[0]));
}

void add_split_option(CLI::App& command, std::string& split) {
  command.add_option("--split", split, "test or train")
      ->check(CLI::IsMember({"test", "train"}))
      ->capture_default_str();
}

namespace {

Expected<void> set_holdout(const std::string& text, LoadOptions& options) {
  constexpr std::string_view kEvery = "every-";
  int n = 0;
  if (text == "none") {
    options.test_every = 0;
  } else if (text.starts_with(kEvery) && CLI::detail::lexical_cast(text.substr(kEvery.size()), n) &&
             n > 1) {
    options.test_every = n;
  } else if (std::error_code ignored; std::filesystem::is_regular_file(text, ignored)) {
    options.test_list = text;
  } else if (!text.empty()) {
    return fail("", "--holdout",
                fmt::format("'{}' is neither none, nor every-N with N of 2 or more, nor a file of "
                            "names",
                            text));
  }
  return {};
}

}  // namespace

Expected<Dataset> load(const DataOptions& options) {
  LoadOptions how;
  if (const auto ok = set_holdout(options.holdout, how); !ok) return std::unexpected(ok.error());
  how.downscale = options.downscale;
  how.trained_side = options.trained_side;
  how.threads = options.threads;
  how.masks = options.masks;
  how.progress = show_progress("images");
  how.video_frames = options.video_frames;
  how.steps = show_steps();
  constexpr double kMebibyte = 1 << 20;
  how.max_photo_bytes = static_cast<std::uint64_t>(options.photo_memory * kMebibyte);
  how.background = glm::vec3(options.background_color());
  auto data = load_dataset(options.folder, how);
  if (data)
    for (const std::string& warning : data->warnings) spdlog::warn("warning: {}", warning);
  if (data && options.video_frames > 0 && !data->kind.starts_with("video"))
    spdlog::warn("warning: --video-frames has no effect, {} is no video", options.folder);
  return data;
}

Expected<std::optional<Dataset>> load_if_given(const DataOptions& options) {
  if (options.folder.empty()) return std::nullopt;
  auto data = load(options);
  if (!data) return std::unexpected(data.error());
  return std::move(*data);
}

void add_size_option(CLI::App& command, ImageSize& size, const std::string& help) {
  command.add_option_function<std::string>(
      "--size",
      [&size](const std::string& text) {
        const auto parsed = parse_size(text);
        if (!parsed) throw CLI::ValidationError("--size", parsed.error().message());
        size = *parsed;
      },
      help);
}

}  // namespace fluxgs::cli
