#include "trainer/data/transforms_source.h"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/ply_points.h"
#include "fluxgs/sanitize.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/transforms_intrinsics.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Adds the vertices of a .ply to the points of the source.
Expected<void> add_ply_points(const fs::path& file, Source& source) {
  const auto bytes = read_file(file);
  if (!bytes) return std::unexpected(bytes.error());
  const auto points = read_ply_points(*bytes, file.string());
  if (!points) return std::unexpected(points.error());
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < points->positions.size(); ++i)
    dropped += !add_point(source, points->positions[i], points->colors[i]);
  if (dropped > 0)
    source.warnings.push_back(
        fmt::format("{}: {} points that are not finite were dropped", file.string(), dropped));
  return {};
}

constexpr std::uint64_t kLargestJson = 1ULL << 28;  // Parsed, it takes ten times as much.

Expected<Json> parse_json(const fs::path& file) {
  const auto text = read_text(file, kLargestJson);
  if (!text) return std::unexpected(text.error());
  try {
    Json json = Json::parse(*text);
    if (!json.is_object() || !json.contains("frames") || !json["frames"].is_array())
      return fail(file.string(), "frames", "missing, expected a list of frames");
    return json;
  } catch (const Json::exception& e) {
    // NaN and Infinity, which Python writes, are no JSON and end here as well.
    return fail(file.string(), "", "not valid JSON: " + one_line(e.what()));
  }
}

/// The image file of a frame: as it says, with an extension added, or under images/ by its bare
/// name (paths from another machine). Nothing if there is no such file.
std::optional<fs::path> find_image(const fs::path& folder, std::string name) {
  const auto with_extensions = [](const fs::path& base) -> std::optional<fs::path> {
    for (const char* extension : {"", ".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"}) {
      fs::path candidate = base;
      candidate += extension;
      if (is_file(candidate)) return candidate;
    }
    return std::nullopt;
  };
  if (auto found = with_extensions((folder / name).lexically_normal())) return found;
  std::ranges::replace(name, '\\', '/');  // Written on Windows
  if (auto found = with_extensions((folder / name).lexically_normal())) return found;
  const fs::path bare = fs::path(name).filename();
  if (bare.empty()) return std::nullopt;
  return with_extensions(folder / "images" / bare);
}

/// The three or four rows of transform_matrix; nothing if they are not rows of four finite numbers
/// or if the fourth is not (0, 0, 0, 1).
std::optional<glm::dmat4> parse_matrix(const Json& json) {
  if (!json.is_array() || json.size() < 3 || json.size() > 4) return std::nullopt;
  glm::dmat4 matrix(1.0);
  for (std::size_t row = 0; row < json.size(); ++row) {
    if (!json[row].is_array() || json[row].size() != 4) return std::nullopt;
    for (std::size_t column = 0; column < 4; ++column) {
      if (!json[row][column].is_number()) return std::nullopt;
      const double value = json[row][column].get<double>();
      if (!std::isfinite(value)) return std::nullopt;
      matrix[static_cast<int>(column)][static_cast<int>(row)] = value;
    }
  }
  const double off = std::abs(matrix[0][3]) + std::abs(matrix[1][3]) + std::abs(matrix[2][3]) +
                     std::abs(matrix[3][3] - 1);
  if (off > 1e-3) return std::nullopt;
  return matrix;
}

Expected<void> set_pose(const Json& frame_json, const std::string& file, const std::string& field,
                        SourceFrame& frame) {
  const auto found = frame_json.find("transform_matrix");
  const auto pose = found == frame_json.end() ? std::nullopt : parse_matrix(*found);
  if (!pose)
    return fail(file, field + "transform_matrix",
                "expected 4 rows of 4 finite numbers, the last row 0 0 0 1");
  const auto rotation = nearest_rotation(glm::dmat3(*pose));
  if (!rotation)
    return fail(file, field + "transform_matrix",
                "not a rigid pose, expected a rotation (right-handed, without shear)");
  // Camera → world with axes (x right, y up, z backward): negating the last two columns gives
  // OpenCV's axes; the transpose inverts the rotation.
  glm::dmat3 camera_to_world = *rotation;
  camera_to_world[1] = -camera_to_world[1];
  camera_to_world[2] = -camera_to_world[2];
  frame.rotation = glm::transpose(camera_to_world);
  frame.translation = -(frame.rotation * glm::dvec3((*pose)[3]));
  return {};
}

/// The frame's image path, as written.
Expected<std::string> file_path_of(const Json& frame, const std::string& file,
                                   const std::string& field) {
  const auto found = frame.is_object() ? frame.find("file_path") : frame.end();
  const bool usable = frame.is_object() && found != frame.end() && found->is_string();
  std::string path = usable ? found->get<std::string>() : "";
  if (path.empty() || path.find('\0') != std::string::npos)
    return fail(file, field + "file_path", "expected the path of an image");
  return path;
}

struct FrameList {
  std::vector<SourceFrame> frames;
  std::size_t skipped = 0;
  std::string first_missing;
  std::vector<std::string> warnings;
};

/// One frame appended to the list, or counted as skipped.
Expected<void> add_frame(const Json& json, const TransformsIntrinsics& global, const fs::path& file,
                         const std::string& field, FrameList& list) {
  const auto path = file_path_of(json, file.string(), field);
  if (!path) return std::unexpected(path.error());
  const auto image = find_image(file.parent_path(), *path);
  if (!image) {
    if (list.skipped++ == 0) list.first_missing = one_line(*path);
    return {};
  }
  SourceFrame frame{.file = *image, .name = image->filename().string(), .lens = {}};
  const auto in = parse_intrinsics(json, global, file.string(), field);
  if (!in) return std::unexpected(in.error());
  if (const auto ok = set_pose(json, file.string(), field, frame); !ok)
    return std::unexpected(ok.error());
  const auto size = read_image_size(*image);
  if (!size) return std::unexpected(size.error());
  const auto lens = make_lens(*in, *size, file.string(), field);
  if (!lens) return std::unexpected(lens.error());
  frame.lens = lens_for_image(*lens, size->width, size->height);
  if (auto odd = shape_warning(*lens, size->width, size->height, image->string()); !odd.empty())
    list.warnings.push_back(std::move(odd));
  list.frames.push_back(std::move(frame));
  return {};
}

Expected<FrameList> read_frames(const Json& json, const fs::path& file) {
  const auto global = parse_intrinsics(json, {}, file.string(), "");
  if (!global) return std::unexpected(global.error());
  FrameList list;
  std::size_t index = 0;
  for (const Json& frame : json["frames"]) {
    const std::string field = fmt::format("frame {}: ", index++);
    if (const auto ok = add_frame(frame, *global, file, field, list); !ok)
      return std::unexpected(ok.error());
  }
  std::set<fs::path> files;
  for (const SourceFrame& frame : list.frames)
    if (!files.insert(frame.file).second)
      return fail(file.string(), fmt::format("frame \"{}\"", one_line(frame.name)),
                  "listed twice, expected every image once");
  return list;
}

void note_warnings(const FrameList& list, const fs::path& file, Source& source) {
  source.warnings.insert(source.warnings.end(), list.warnings.begin(), list.warnings.end());
  source.skipped_images += list.skipped;
  if (list.skipped > 0)
    source.warnings.push_back(fmt::format(
        "{}: {} of {} frames have no image file and are skipped; first: {}", file.string(),
        list.skipped, list.skipped + list.frames.size(), list.first_missing));
}

/// nerfstudio's sparse points, which its exporter has already moved into the frames' world.
Expected<void> read_ply(const Json& json, const fs::path& file, Source& source) {
  const auto found = json.find("ply_file_path");
  if (found == json.end() || !found->is_string()) return {};
  const fs::path ply = file.parent_path() / found->get<std::string>();
  if (!is_file(ply)) {
    source.warnings.push_back(
        fmt::format("{}: ply_file_path: no such file: {}", file.string(), one_line(ply.string())));
    return {};
  }
  source.points_file = ply;
  return add_ply_points(ply, source);
}

}  // namespace

bool has_transforms(const fs::path& folder) {
  return is_file(folder / "transforms_train.json") || is_file(folder / "transforms.json");
}

Expected<Source> read_transforms_source(const fs::path& folder) {
  const bool split = is_file(folder / "transforms_train.json");
  const fs::path file = folder / (split ? "transforms_train.json" : "transforms.json");
  const auto json = parse_json(file);
  if (!json) return std::unexpected(json.error());
  auto train = read_frames(*json, file);
  if (!train) return std::unexpected(train.error());

  Source source;
  note_warnings(*train, file, source);
  source.frames = std::move(train->frames);
  if (const auto ok = read_ply(*json, file, source); !ok) return std::unexpected(ok.error());

  const fs::path test_file = folder / "transforms_test.json";
  if (!split || !is_file(test_file)) return source;
  const auto test_json = parse_json(test_file);
  if (!test_json) return std::unexpected(test_json.error());
  auto test = read_frames(*test_json, test_file);
  if (!test) return std::unexpected(test.error());
  note_warnings(*test, test_file, source);
  source.test_frames = std::move(test->frames);
  source.has_split = true;
  return source;
}

}  // namespace fluxgs
