#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/source.h"

namespace fluxgs {
namespace {

/// The lines of a text file, with the number of records that its opening comment promises.
class LineFile {
 public:
  LineFile(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {}

  const std::string& path() const { return path_; }
  std::size_t line_number() const { return line_; }
  bool is_empty() const { return text_.empty(); }

  /// The next line, whatever it holds; nothing at the end.
  std::optional<std::string_view> next() {
    if (at_ >= text_.size()) return std::nullopt;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line(text_.data() + at_, end - at_);
    at_ = end + 1;
    ++line_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  /// The last line again, by the next call of next() or next_record().
  void put_back(std::string_view line) {
    at_ = static_cast<std::size_t>(line.data() - text_.data());
    --line_;
  }

  /// The next line that is neither empty nor a comment.
  std::optional<std::string_view> next_record() {
    while (const auto line = next()) {
      const std::size_t first = line->find_first_not_of(" \t");
      if (first == std::string_view::npos) continue;
      if ((*line)[first] != '#') return line;
      note_promise(*line);
    }
    return std::nullopt;
  }

  std::unexpected<Error> bad(std::string_view expected) const {
    return fail(path_, fmt::format("line {}", line_), fmt::format("expected {}", expected));
  }

  /// COLMAP writes "# Number of images: 97, …" at the top. A comment binds nobody, but tells a file
  /// that was cut inside a line from one that was edited.
  Expected<void> check_count(std::size_t count, ColmapModel& model) const {
    if (!promised_ || *promised_ == count) return {};
    const std::string text = fmt::format("promises {} records and has {}", *promised_, count);
    if (count < *promised_ && !text_.ends_with('\n'))
      return fail(path_, "", text + ": it is truncated");
    model.warnings.push_back(fmt::format("{}: {}: it was edited", path_, text));
    return {};
  }

 private:
  void note_promise(std::string_view comment) {
    const std::size_t start = comment.find("Number of ");
    if (start == std::string_view::npos) return;
    const std::size_t colon = comment.find(": ", start);
    if (colon == std::string_view::npos) return;
    std::size_t value = 0;
    const char* end = comment.data() + comment.size();
    if (std::from_chars(comment.data() + colon + 2, end, value).ec == std::errc{})
      promised_ = value;
  }

  std::string path_, text_;
  std::size_t at_ = 0, line_ = 0;
  std::optional<std::size_t> promised_;
};

Expected<LineFile> open_lines(const std::filesystem::path& path) {
  auto text = read_text(path);
  if (!text) return std::unexpected(text.error());
  return LineFile(path.string(), std::move(*text));
}

std::string_view trim_left(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text;
}

std::string_view trim(std::string_view text) {
  text = trim_left(text);
  return text.substr(0, text.find_last_not_of(" \t") + 1);
}

/// Take the next word off the front of a line; empty at its end.
std::string_view take_word(std::string_view& line) {
  line = trim_left(line);
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

/// Take a number off the front of a line; false if there is none.
template <class T>
bool take(std::string_view& line, T& value) {
  const std::string_view word = take_word(line);
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  return !word.empty() && result.ec == std::errc{} && result.ptr == word.data() + word.size();
}

template <class... T>
bool take_all(std::string_view& line, T&... values) {
  return (take(line, values) && ...);
}

Expected<void> read_text_cameras(const std::filesystem::path& path, ColmapModel& model) {
  auto file = open_lines(path);
  if (!file) return std::unexpected(file.error());
  if (file->is_empty()) return fail(path.string(), "", "is empty, expected a COLMAP text file");
  while (auto line = file->next_record()) {
    std::uint32_t id = 0;
    if (!take(*line, id)) return file->bad("CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]");
    const std::string name(take_word(*line));
    const ColmapCameraModel* camera_model = find_camera_model(std::string_view(name));
    if (!camera_model) {
      model.cameras.emplace(id, fail(path.string(), fmt::format("camera {}", id),
                                     fmt::format("unknown camera model \"{}\"", one_line(name))));
      continue;
    }
    std::uint64_t width = 0, height = 0;
    std::vector<double> parameters(static_cast<std::size_t>(camera_model->parameters));
    bool ok = take_all(*line, width, height);
    for (double& p : parameters) ok = ok && take(*line, p);
    if (!ok || !trim(*line).empty())
      return file->bad(
          fmt::format("CAMERA_ID {} WIDTH HEIGHT and {} parameters", name, parameters.size()));
    if (!model.cameras
             .emplace(id, make_colmap_lens(*camera_model, width, height, parameters, path.string(),
                                           fmt::format("camera {}", id)))
             .second)
      return fail(path.string(), fmt::format("camera {}", id),
                  "listed twice, expected every camera once");
  }
  return file->check_count(model.cameras.size(), model);
}

/// POINTS2D[] as (X, Y, POINT3D_ID); false if it is anything else.
bool read_observations(std::string_view line, std::vector<ColmapObservation>& observations) {
  while (!trim(line).empty()) {
    ColmapObservation o;
    if (!take_all(line, o.pixel.x, o.pixel.y, o.point_id)) return false;
    observations.push_back(o);
  }
  return true;
}

/// "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME"; nothing if a line is anything else.
std::optional<ColmapImage> parse_image(std::string_view line) {
  ColmapImage image;
  std::uint32_t id = 0;
  auto& q = image.rotation;
  auto& t = image.translation;
  const bool ok = take_all(line, id, q.w, q.x, q.y, q.z, t.x, t.y, t.z, image.camera_id);
  image.name = std::string(trim(line));  // The rest of the line: names may hold spaces.
  if (!ok || image.name.empty()) return std::nullopt;
  return image;
}

Expected<void> read_text_images(const std::filesystem::path& path, ColmapModel& model) {
  auto file = open_lines(path);
  if (!file) return std::unexpected(file.error());
  if (file->is_empty()) return fail(path.string(), "", "is empty, expected a COLMAP text file");
  while (auto line = file->next_record()) {
    auto image = parse_image(*line);
    if (!image) return file->bad("IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    // The second line of a record may be empty, and is missing in some hand-written files.
    const auto points = file->next();
    if (points && !read_observations(*points, image->observations)) {
      if (!parse_image(*points)) return file->bad("POINTS2D[] as (X, Y, POINT3D_ID)");
      image->observations.clear();
      file->put_back(*points);
    }
    model.images.push_back(std::move(*image));
  }
  return file->check_count(model.images.size(), model);
}

Expected<void> read_text_points(const std::filesystem::path& path, ColmapModel& model) {
  auto file = open_lines(path);
  if (!file) return std::unexpected(file.error());
  while (auto line = file->next_record()) {
    ColmapPoint point;
    int r = 0, g = 0, b = 0;
    double error = 0;
    auto& p = point.position;
    const bool ok = take_all(*line, point.id, p.x, p.y, p.z, r, g, b, error);
    const auto in_range = [](int c) { return c >= 0 && c <= 255; };
    if (!ok || !in_range(r) || !in_range(g) || !in_range(b))
      return file->bad("POINT3D_ID X Y Z R G B ERROR TRACK[]");
    point.color = glm::u8vec3(r, g, b);
    model.points.push_back(point);
  }
  return file->check_count(model.points.size(), model);
}

}  // namespace

Expected<ColmapModel> read_colmap_text(const std::filesystem::path& folder) {
  ColmapModel model;
  if (const auto ok = read_text_cameras(folder / "cameras.txt", model); !ok)
    return std::unexpected(ok.error());
  if (const auto ok = read_text_images(folder / "images.txt", model); !ok)
    return std::unexpected(ok.error());
  model.has_points_file = is_file(folder / "points3D.txt");
  if (!model.has_points_file) return model;
  if (const auto ok = read_text_points(folder / "points3D.txt", model); !ok)
    return std::unexpected(ok.error());
  return model;
}

}  // namespace fluxgs
