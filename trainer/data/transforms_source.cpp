#include "trainer/data/transforms_source.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/sanitize.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/file_list.h"
#include "trainer/data/image_finder.h"
#include "trainer/data/transforms_intrinsics.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint64_t kLargestJson = 1ULL << 28;  // Parsed, it takes ten times as much.

/// NaN and Infinity, which Python writes and JSON does not have, become null. Nothing inside of
/// texts is touched.
std::string with_finite_numbers(const std::string& text) {
  std::string result;
  result.reserve(text.size());
  bool quoted = false;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (quoted && c == '\\' && at + 1 < text.size()) {
      result += text.substr(at, 2);
      at += 2;
      continue;
    }
    if (c == '"') quoted = !quoted;
    bool replaced = false;
    for (const std::string_view word : {"-Infinity", "Infinity", "NaN"})
      if (!quoted && !replaced && text.compare(at, word.size(), word) == 0) {
        result += "null";
        at += word.size();
        replaced = true;
      }
    if (!replaced) result += text[at++];
  }
  return result;
}

/// The fault of a text that is no JSON.
std::string json_fault(const std::string& text, std::size_t byte) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    return "is empty, expected JSON with a list of frames";
  const std::string_view before = std::string_view(text).substr(0, byte > 0 ? byte - 1 : 0);
  if (byte > text.size())
    return fmt::format("not valid JSON: it ends in line {}; is it cut off?",
                       1 + std::ranges::count(before, '\n'));
  return fmt::format("not valid JSON: line {}, column {}", 1 + std::ranges::count(before, '\n'),
                     before.size() - (before.rfind('\n') + 1) + 1);
}

Expected<Json> parse_json(const fs::path& file) {
  const auto read = read_text(file, kLargestJson);
  if (!read) return std::unexpected(read.error());
  const std::string text = with_finite_numbers(*read);
  try {
    Json json = Json::parse(text);
    const bool has_frames = json.is_object() && json.contains("frames");
    if (!has_frames || !json["frames"].is_array())
      return fail(file.string(), "frames",
                  fmt::format("{}, expected a list of frames", has_frames ? "is none" : "missing"));
    return json;
  } catch (const Json::parse_error& e) {
    return fail(file.string(), "", json_fault(text, e.byte));
  } catch (const Json::exception& e) {
    // "[json.exception.out_of_range.406] number overflow parsing '1e999'"
    const std::string what = one_line(e.what());
    return fail(file.string(), "", "not valid JSON: " + what.substr(what.find("] ") + 2));
  }
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

/// True if a matrix of numbers holds one that is not finite: tracking was lost.
bool has_lost_pose(const Json& frame) {
  const auto found = frame.find("transform_matrix");
  if (found == frame.end() || !found->is_array()) return false;
  bool lost = false;
  for (const Json& row : *found)
    for (const Json& value : row)
      lost = lost || value.is_null() || (value.is_number() && !std::isfinite(value.get<double>()));
  return lost;
}

/// Names the frames by their paths below the folder that all of them are in.
void name_frames(std::vector<SourceFrame>& frames) {
  if (frames.empty()) return;
  fs::path common = frames.front().file.parent_path();
  const auto holds = [&](const SourceFrame& f) {
    const fs::path below = f.file.lexically_relative(common);
    return !below.empty() && *below.begin() != "..";
  };
  while (!std::ranges::all_of(frames, holds) && common.has_relative_path())
    common = common.parent_path();
  for (SourceFrame& f : frames) f.name = f.file.lexically_relative(common).generic_string();
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
  FileList missing, without_pose, missing_masks;
  FailedImages bad;  ///< frames that say what cannot be
};

/// The mask that nerfstudio names: of the frame, or of the whole file. The photo itself is none,
/// where only that has the mask's name.
void set_mask(const Json& json, const Json& all, const ImageFinder& files, SourceFrame& frame,
              FileList& missing) {
  const auto own = json.find("mask_path");
  const Json& path = own != json.end() ? *own : all.value("mask_path", Json());
  if (!path.is_string() || path.get<std::string>().empty()) return;
  const auto found = files.find(path.get<std::string>());
  if (found && *found != frame.file)
    frame.mask = *found;
  else
    missing.add(path.get<std::string>());
}

/// Size of an image whose camera has none: as stored, or turned by Exif where the principal point
/// then lies nearer to the middle.
ImageSize size_for(const TransformsIntrinsics& in, const ImageOutline& image) {
  const ImageSize stored = image.size, turned{stored.height, stored.width};
  if (!swaps_sides(image.exif.orientation) || !in.center_x || !in.center_y) return stored;
  const auto off_centre = [&](ImageSize size) {
    return std::hypot(*in.center_x - 0.5 * size.width, *in.center_y - 0.5 * size.height);
  };
  return off_centre(turned) < off_centre(stored) ? turned : stored;
}

/// One frame appended to the list, or counted as left out.
Expected<void> add_frame(const Json& json, const TransformsIntrinsics& global, const fs::path& file,
                         const std::string& field, const ImageFinder& images, FrameList& list) {
  const auto path = file_path_of(json, file.string(), field);
  if (!path) return std::unexpected(path.error());
  const auto image = images.find(*path);
  if (!image) {
    list.missing.add(*path);
    return {};
  }
  if (has_lost_pose(json)) {
    list.without_pose.add(*path);
    return {};
  }
  SourceFrame frame{.file = *image, .name = {}, .lens = {}};
  const auto in = parse_intrinsics(json, global, file.string(), field);
  if (!in) return std::unexpected(in.error());
  if (const auto ok = set_pose(json, file.string(), field, frame); !ok)
    return std::unexpected(ok.error());
  // Only a camera without a size needs that of its image. One that cannot be read is left out later
  ImageSize size{1, 1};
  if (!in->width || !in->height)
    if (const auto outline = read_image_outline(*image)) size = size_for(*in, *outline);
  const auto lens = make_lens(*in, size, file.string(), field);
  if (!lens) return std::unexpected(lens.error());
  frame.lens = *lens;
  list.frames.push_back(std::move(frame));
  return {};
}

/// The texts under a key of the frames, and of the whole file.
std::vector<std::string> texts_of(const Json& json, const char* key) {
  std::vector<std::string> texts;
  const auto add = [&](const Json& object) {
    const auto found = object.find(key);
    if (found != object.end() && found->is_string()) texts.push_back(found->get<std::string>());
  };
  add(json);
  for (const Json& frame : json["frames"])
    if (frame.is_object()) add(frame);
  return texts;
}

Expected<FrameList> read_frames(const Json& json, const fs::path& file,
                                const std::vector<fs::path>& image_folders) {
  const auto global = parse_intrinsics(json, {}, file.string(), "");
  if (!global) return std::unexpected(global.error());
  FrameList list;
  const ImageFinder images(image_folders, texts_of(json, "file_path"));
  const ImageFinder masks({file.parent_path()}, texts_of(json, "mask_path"));
  std::size_t index = 0;
  for (const Json& frame : json["frames"]) {
    const std::string field = fmt::format("frame {}: ", index++);
    const std::size_t before = list.frames.size();
    if (const auto ok = add_frame(frame, *global, file, field, images, list); !ok) {
      list.bad.add(fmt::format("frame {}", index - 1), ok.error());
    }
    if (list.frames.size() > before)
      set_mask(frame, json, masks, list.frames.back(), list.missing_masks);
  }
  name_frames(list.frames);
  std::set<fs::path> files;
  std::erase_if(list.frames, [&](const SourceFrame& frame) {
    if (files.insert(frame.file).second) return false;
    list.bad.add(frame.name, Error{file.string(), fmt::format("frame \"{}\"", one_line(frame.name)),
                                   "listed twice, expected every image once"});
    return true;
  });
  if (const std::size_t all = json["frames"].size(); all > 0 && 2 * list.bad.size() >= all)
    return list.bad.failure(all);
  return list;
}

void note_warnings(const FrameList& list, const fs::path& file, Source& source) {
  source.skipped_images += list.missing.size() + list.without_pose.size() + list.bad.size();
  list.bad.warn(source.warnings);
  if (!list.missing.empty())
    source.warnings.push_back(fmt::format(
        "{}: {} of {} frames have no image file and are skipped: {}", file.string(),
        list.missing.size(), list.missing.size() + list.without_pose.size() + list.frames.size(),
        list.missing.text()));
  if (!list.without_pose.empty())
    source.warnings.push_back(
        fmt::format("{}: the poses of {} frames are not finite; they are skipped: {}",
                    file.string(), list.without_pose.size(), list.without_pose.text()));
  if (!list.missing_masks.empty())
    source.warnings.push_back(
        fmt::format("{}: mask_path: {} masks are not there; their photos count whole: {}",
                    file.string(), list.missing_masks.size(), list.missing_masks.text()));
}

/// Points that nothing names are not read: the 3DGS trainer leaves random ones there.
void tell_of_ply_beside(const fs::path& file, Source& source) {
  for (const char* name : {"points3d.ply", "points3D.ply"})
    if (is_file(file.parent_path() / name))
      source.warnings.push_back(fmt::format(
          "{}: {} beside it is not read; \"ply_file_path\": \"{}\" would begin with its points",
          file.string(), name, name));
}

/// nerfstudio's sparse points, which its exporter has already moved into the frames' world.
Expected<void> read_ply(const Json& json, const fs::path& file, Source& source) {
  const auto path = json.find("ply_file_path");
  if (path == json.end() || !path->is_string()) {
    tell_of_ply_beside(file, source);
    return {};
  }
  const std::string name = path->get<std::string>();
  const auto ply = ImageFinder({file.parent_path()}, {name}).find(name);
  if (!ply) {
    source.warnings.push_back(
        fmt::format("{}: ply_file_path: no such file: {}", file.string(), one_line(name)));
    return {};
  }
  source.points_file = *ply;
  return add_ply_points(*ply, source);
}

/// nerfstudio's lists of file paths; what it validates with is for testing, too.
SplitLists read_split(const Json& json, const fs::path& file) {
  SplitLists lists;
  const auto add = [&](const char* key, std::vector<std::string>& names) {
    const auto list = json.find(key);
    if (list == json.end() || !list->is_array()) return;
    for (const Json& name : *list)
      if (name.is_string()) names.push_back(name.get<std::string>());
  };
  add("train_filenames", lists.train);
  add("test_filenames", lists.test);
  add("val_filenames", lists.test);
  if (!lists.train.empty() || !lists.test.empty()) lists.file = file.string();
  return lists;
}

}  // namespace

bool has_transforms(const fs::path& folder) { return is_file(transforms_file(folder)); }

fs::path transforms_file(const fs::path& folder) {
  const fs::path train = folder / "transforms_train.json";
  return is_file(train) ? train : folder / "transforms.json";
}

Expected<Source> read_transforms_source(const fs::path& file,
                                        const std::vector<fs::path>& image_folders) {
  const bool split = file.filename() == "transforms_train.json";
  const auto json = parse_json(file);
  if (!json) return std::unexpected(json.error());
  auto train = read_frames(*json, file, image_folders);
  if (!train) return std::unexpected(train.error());

  Source source;
  if ((*json)["frames"].empty())
    source.warnings.push_back(file.string() + ": frames: the list is empty");
  note_warnings(*train, file, source);
  source.frames = std::move(train->frames);
  source.split = read_split(*json, file);
  if (const auto ok = read_ply(*json, file, source); !ok) return std::unexpected(ok.error());

  const fs::path test_file = file.parent_path() / "transforms_test.json";
  if (!split || !is_file(test_file)) return source;
  const auto test_json = parse_json(test_file);
  if (!test_json) return std::unexpected(test_json.error());
  auto test = read_frames(*test_json, test_file, image_folders);
  if (!test) return std::unexpected(test.error());
  note_warnings(*test, test_file, source);
  source.test_frames = std::move(test->frames);
  source.has_split = true;
  return source;
}

}  // namespace fluxgs
