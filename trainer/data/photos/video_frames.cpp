#include "trainer/data/photos/video_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "fluxgs/sanitize.h"
#include "trainer/core/process.h"
#include "trainer/data/file_bytes.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

constexpr int kSide = 512;          // pixels of the grey copies that sharpness is measured on
constexpr double kFastest = 30;     // frames a second that are looked at
constexpr double kCandidates = 15;  // frames that are looked at for one that is taken

/// Formats of single files: a playlist would lead to other files and addresses, or never end.
constexpr const char* kFormats =
    "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg,mpegvideo,asf,flv,ogg,gif,m4v,mjpeg,"
    "h264,"
    "hevc,dv,mxf";

/// ffmpeg on one video, with its log.
struct Ffmpeg {
  fs::path program, video, log;

  std::vector<std::string> arguments(const std::vector<std::string>& output) const {
    std::vector<std::string> all{"-nostdin",
                                 "-hide_banner",
                                 "-nostats",
                                 "-protocol_whitelist",
                                 "file,pipe",
                                 "-format_whitelist",
                                 kFormats,
                                 "-i",
                                 "file:" + fs::absolute(video).string()};
    all.insert(all.end(), output.begin(), output.end());
    return all;
  }
  std::string log_text() const { return read_text(log).value_or(std::string()); }
  /// The last message of ffmpeg, without the part of its code that said it.
  std::string last_line() const {
    const std::string text = log_text();
    std::string_view rest(text), last;
    while (!rest.empty()) {
      const std::string_view line = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(line.size() + 1, rest.size()));
      if (line.find_first_not_of(" \r") != std::string_view::npos) last = line;
    }
    if (last.starts_with('[') && last.find("] ") != std::string_view::npos)
      last.remove_prefix(last.find("] ") + 2);
    std::string shown(last);
    const std::string name = "file:" + fs::absolute(video).string() + ": ";
    if (shown.starts_with(name)) shown.erase(0, name.size());
    return one_line(shown, 160);
  }
};

/// Seconds, as ffmpeg's log has them; nothing if it does not know.
std::optional<double> duration_in(const std::string& log) {
  const std::size_t at = log.find("Duration: ");
  int hours = 0, minutes = 0;
  double seconds = 0;
  if (at == std::string::npos ||
      std::sscanf(log.c_str() + at, "Duration: %d:%d:%lf", &hours, &minutes, &seconds) != 3)
    return std::nullopt;
  const double all = hours * 3600.0 + minutes * 60.0 + seconds;
  return all > 0 ? std::optional(all) : std::nullopt;
}

double sharpness_of(const std::uint8_t* pixels) {
  const cv::Mat grey(kSide, kSide, CV_8UC1, const_cast<std::uint8_t*>(pixels));
  cv::Mat laplacian;
  cv::Laplacian(grey, laplacian, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

/// Measures the frames of a stream of raw pixels, however it is cut into pieces.
class SharpnessMeter {
 public:
  void add(std::string_view bytes) {
    constexpr std::size_t kFrame = static_cast<std::size_t>(kSide) * kSide;
    while (!bytes.empty()) {
      const std::size_t count = std::min(bytes.size(), kFrame - frame_.size());
      frame_.insert(frame_.end(), bytes.begin(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(count));
      bytes.remove_prefix(count);
      if (frame_.size() < kFrame) continue;
      values_.push_back(sharpness_of(frame_.data()));
      frame_.clear();
    }
  }
  const std::vector<double>& values() const { return values_; }

 private:
  std::vector<std::uint8_t> frame_;
  std::vector<double> values_;
};

/// Removes the unfinished folder with the object.
struct PartialFolder {
  fs::path path;
  ~PartialFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

Expected<std::vector<double>> measure_sharpness(const Ffmpeg& ffmpeg, double rate,
                                                std::optional<double> duration,
                                                const StepReport& report) {
  SharpnessMeter meter;
  const auto total = static_cast<std::size_t>(duration.value_or(0) * rate);
  const auto tell = [&] {
    const std::size_t done = std::min(meter.values().size(), total > 0 ? total - 1 : 0);
    if (report && total > 1) report("looking for sharp frames", "frames", done, total);
  };
  const std::string filter =
      fmt::format("fps={},scale={}:{}:flags=area,format=gray", rate, kSide, kSide);
  const ProcessEnd end = run(
      {ffmpeg.program, ffmpeg.arguments({"-map", "0:v:0", "-vf", filter, "-f", "rawvideo", "-"}),
       ffmpeg.log},
      [&](std::string_view bytes) {
        meter.add(bytes);
        tell();
      },
      Captured::output);
  if (end.signal > 0 || end.status < 0)
    return fail(ffmpeg.video.string(), "", "ffmpeg " + end.text());
  if (meter.values().empty())
    return fail(
        ffmpeg.video.string(), "",
        fmt::format("no frame of a video can be read; ffmpeg says: {}", ffmpeg.last_line()));
  const std::size_t all = meter.values().size();  // the duration gives them roughly
  if (report) report("looking for sharp frames", "frames", all, all);
  return meter.values();
}

Expected<void> write_frames(const Ffmpeg& ffmpeg, double rate,
                            const std::vector<std::size_t>& chosen, const fs::path& folder,
                            const StepReport& report) {
  std::string which;
  for (const std::size_t index : chosen)
    which += fmt::format("{}eq(n,{})", which.empty() ? "" : "+", index);
  // Time stamps without gaps, which ffmpeg would fill with copies
  const std::string filter =
      fmt::format("fps={},select='{}',setpts=N/FRAME_RATE/TB,format=yuvj420p", rate, which);
  if (report) report("writing frames", "frames", 0, chosen.size());
  const ProcessEnd end = run(
      {ffmpeg.program,
       ffmpeg.arguments({"-map", "0:v:0", "-vf", filter, "-q:v", "2", "-f", "image2",
                         (folder / "frame_%05d.jpg").string()}),
       ffmpeg.log},
      [](std::string_view) {}, Captured::output);
  if (report) report("writing frames", "frames", chosen.size(), chosen.size());
  if (end.status != 0)
    return fail(ffmpeg.video.string(), "",
                fmt::format("ffmpeg {}: {}", end.text(), ffmpeg.last_line()));
  return {};
}

}  // namespace

std::vector<std::size_t> sharpest_frames(std::span<const double> sharpness, std::size_t count) {
  const std::size_t all = sharpness.size(), parts = std::min(count, all);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < parts; ++i) {
    const std::size_t begin = i * all / parts, end = (i + 1) * all / parts;
    const auto part = sharpness.subspan(begin, end - begin);
    chosen.push_back(begin +
                     static_cast<std::size_t>(std::ranges::max_element(part) - part.begin()));
  }
  return chosen;
}

Expected<void> extract_video_frames(const fs::path& video, int count, const fs::path& folder,
                                    const StepReport& report, std::vector<std::string>& warnings) {
  const auto program = find_program("ffmpeg");
  if (!program)
    return fail(video.string(), "",
                "a video needs ffmpeg, which is not installed (apt install ffmpeg); or give a "
                "folder of photos");
  const PartialFolder partial{folder.string() + ".partial"};
  std::error_code error;
  fs::remove_all(partial.path, error);
  fs::create_directories(partial.path, error);
  if (error) return fail(partial.path.string(), "", "cannot be created: " + error.message());
  const Ffmpeg ffmpeg{*program, video, partial.path / "ffmpeg.log"};

  run({ffmpeg.program, ffmpeg.arguments({}), ffmpeg.log});  // only describes the file
  const auto duration = duration_in(ffmpeg.log_text());
  const double wanted = duration ? kCandidates * count / *duration : kFastest;
  const double rate = std::clamp(std::ceil(wanted), 1.0, kFastest);
  const auto sharpness = measure_sharpness(ffmpeg, rate, duration, report);
  if (!sharpness) return std::unexpected(sharpness.error());
  const double seconds = static_cast<double>(sharpness->size()) / rate;
  if (duration && seconds < 0.9 * *duration - 1)
    warnings.push_back(fmt::format("{}: only the first {:.0f} of {:.0f} seconds can be read",
                                   video.string(), seconds, *duration));
  const auto chosen = sharpest_frames(*sharpness, static_cast<std::size_t>(count));
  if (auto ok = write_frames(ffmpeg, rate, chosen, partial.path, report); !ok) return ok;
  fs::remove(ffmpeg.log, error);
  fs::remove_all(folder, error);
  fs::rename(partial.path, folder, error);
  if (error) return fail(folder.string(), "", "cannot be written: " + error.message());
  return {};
}

}  // namespace fluxgs
