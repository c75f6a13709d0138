#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "fluxgs/byte_reader.h"
#include "fluxgs/io/file.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/file_bytes.h"

namespace fluxgs {
namespace {

/// One binary file: a count, then as many records.
struct RecordFile {
  std::string path;
  std::vector<std::byte> bytes;

  std::unexpected<Error> cut(std::string_view record, std::uint64_t index) const {
    return fail(path, fmt::format("{} {}", record, index),
                fmt::format("the file ends inside it, after {} bytes: it is truncated or not a "
                            "COLMAP file",
                            bytes.size()));
  }
};

Expected<RecordFile> open_records(const std::filesystem::path& file) {
  auto bytes = read_file(file);
  if (!bytes) return std::unexpected(bytes.error());
  return RecordFile{file.string(), std::move(*bytes)};
}

/// The count at the front of the file, refused where even the smallest records would not fit.
Expected<std::uint64_t> take_count(ByteReader& reader, const RecordFile& file,
                                   std::string_view records, std::size_t smallest) {
  const auto count = reader.take<std::uint64_t>();
  if (!count)
    return fail(
        file.path, "header",
        fmt::format("{} bytes, expected a count of {} in 8 bytes", file.bytes.size(), records));
  if (*count > reader.left() / smallest)
    return fail(file.path, "header",
                fmt::format("promises {} {}, but the file has room for at most {}: it is truncated "
                            "or not a COLMAP file",
                            *count, records, reader.left() / smallest));
  return *count;
}

Expected<void> expect_end(const ByteReader& reader, const RecordFile& file,
                          std::string_view records) {
  if (reader.left() == 0) return {};
  return fail(file.path, "",
              fmt::format("{} bytes too many after the last of its {}", reader.left(), records));
}

Expected<void> read_binary_cameras(const std::filesystem::path& path, ColmapModel& model) {
  const auto file = open_records(path);
  if (!file) return std::unexpected(file.error());
  ByteReader reader(file->bytes);
  const auto count = take_count(reader, *file, "cameras", 24);
  if (!count) return std::unexpected(count.error());
  for (std::uint64_t i = 0; i < *count; ++i) {
    const auto id = reader.take<std::uint32_t>();
    const auto model_id = reader.take<std::int32_t>();
    const auto width = reader.take<std::uint64_t>(), height = reader.take<std::uint64_t>();
    if (!id || !model_id || !width || !height) return file->cut("camera", i);
    const std::string field = fmt::format("camera {}", *id);
    const ColmapCameraModel* camera_model = find_camera_model(*model_id);
    if (!camera_model)
      return fail(file->path, field, fmt::format("unknown camera model number {}", *model_id));
    std::vector<double> parameters;
    for (int k = 0; k < camera_model->parameters; ++k) {
      const auto value = reader.take<double>();
      if (!value) return file->cut("camera", i);
      parameters.push_back(*value);
    }
    if (!model.cameras
             .emplace(*id, make_colmap_lens(*camera_model, *width, *height, parameters, file->path,
                                            field))
             .second)
      return fail(file->path, field, "listed twice, expected every camera once");
  }
  return expect_end(reader, *file, "cameras");
}

Expected<ColmapImage> read_image_record(ByteReader& reader, const RecordFile& file,
                                        std::uint64_t index) {
  const auto id = reader.take<std::uint32_t>();
  const auto pose = reader.take<std::array<double, 7>>();
  const auto camera_id = reader.take<std::uint32_t>();
  const auto name = reader.take_c_string();
  const auto observations = reader.take<std::uint64_t>();
  if (!id || !pose || !camera_id || !name || !observations) return file.cut("image", index);
  struct Record {
    double x, y;
    std::int64_t point_id;
  };
  if (*observations > reader.left() / sizeof(Record))
    return fail(file.path, fmt::format("image {}", index),
                fmt::format("promises {} points, but the file has room for at most {}: it is "
                            "truncated or corrupt",
                            *observations, reader.left() / sizeof(Record)));
  const auto& p = *pose;
  ColmapImage image{.name = *name,
                    .camera_id = *camera_id,
                    .rotation = glm::dquat(p[0], p[1], p[2], p[3]),
                    .translation = {p[4], p[5], p[6]},
                    .observations = {}};
  image.observations.reserve(*observations);
  for (std::uint64_t k = 0; k < *observations; ++k) {
    const auto record = reader.take<Record>();
    if (!record) return file.cut("image", index);
    image.observations.push_back({{record->x, record->y}, record->point_id});
  }
  return image;
}

Expected<void> read_binary_images(const std::filesystem::path& path, ColmapModel& model) {
  const auto file = open_records(path);
  if (!file) return std::unexpected(file.error());
  ByteReader reader(file->bytes);
  const auto count = take_count(reader, *file, "images", 4 + 56 + 4 + 1 + 8);
  if (!count) return std::unexpected(count.error());
  for (std::uint64_t i = 0; i < *count; ++i) {
    auto image = read_image_record(reader, *file, i);
    if (!image) return std::unexpected(image.error());
    model.images.push_back(std::move(*image));
  }
  return expect_end(reader, *file, "images");
}

Expected<void> read_binary_points(const std::filesystem::path& path, ColmapModel& model) {
  const auto file = open_records(path);
  if (!file) return std::unexpected(file.error());
  ByteReader reader(file->bytes);
  const auto count = take_count(reader, *file, "points", 8 + 24 + 3 + 8 + 8);
  if (!count) return std::unexpected(count.error());
  model.points.reserve(*count);
  for (std::uint64_t i = 0; i < *count; ++i) {
    const auto id = reader.take<std::uint64_t>();
    const auto position = reader.take<std::array<double, 3>>();
    const auto color = reader.take<std::array<std::uint8_t, 3>>();
    const auto error = reader.take<double>();
    const auto track = reader.take<std::uint64_t>();
    constexpr std::size_t kTrackElement = 8;  // image id, index of the observation
    if (!id || !position || !color || !error || !track || *track > reader.left() / kTrackElement ||
        !reader.take_bytes(*track * kTrackElement))
      return file->cut("point", i);
    const auto& p = *position;
    const auto& c = *color;
    model.points.push_back({*id, {p[0], p[1], p[2]}, {c[0], c[1], c[2]}});
  }
  return expect_end(reader, *file, "points");
}

}  // namespace

Expected<ColmapModel> read_colmap_binary(const std::filesystem::path& folder) {
  ColmapModel model;
  if (const auto ok = read_binary_cameras(folder / "cameras.bin", model); !ok)
    return std::unexpected(ok.error());
  if (const auto ok = read_binary_images(folder / "images.bin", model); !ok)
    return std::unexpected(ok.error());
  model.has_points_file = is_file(folder / "points3D.bin");
  if (!model.has_points_file) return model;
  if (const auto ok = read_binary_points(folder / "points3D.bin", model); !ok)
    return std::unexpected(ok.error());
  return model;
}

bool is_binary_model(const std::filesystem::path& folder) {
  const auto has = [&](const char* name) { return is_file(folder / name); };
  const bool text = has("cameras.txt") && has("images.txt");
  const bool binary = has("cameras.bin") && has("images.bin");
  return binary || (!text && (has("cameras.bin") || has("images.bin")));
}

Expected<ColmapModel> read_colmap_model(const std::filesystem::path& folder) {
  return is_binary_model(folder) ? read_colmap_binary(folder) : read_colmap_text(folder);
}

namespace {

std::vector<ColmapModelFolder> list_models(const std::filesystem::path& sparse) {
  std::vector<ColmapModelFolder> models;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(sparse, error))
    if (is_colmap_model(entry.path())) models.push_back({entry.path()});
  return models;
}

std::uint64_t count_images(const std::filesystem::path& model) {
  if (is_binary_model(model)) {
    const auto head = read_prefix(model / "images.bin", 8);
    return head ? ByteReader(*head).take<std::uint64_t>().value_or(0) : 0;
  }
  const auto text = read_colmap_text(model);
  return text ? text->images.size() : 0;
}

}  // namespace

bool has_colmap_models(const std::filesystem::path& sparse) { return !list_models(sparse).empty(); }

std::vector<ColmapModelFolder> colmap_models(const std::filesystem::path& sparse) {
  std::vector<ColmapModelFolder> models = list_models(sparse);
  if (models.size() < 2) return models;
  for (ColmapModelFolder& model : models) model.images = count_images(model.folder);
  std::ranges::sort(models, [](const ColmapModelFolder& a, const ColmapModelFolder& b) {
    return std::pair(b.images, a.folder) < std::pair(a.images, b.folder);
  });
  return models;
}

bool is_colmap_model(const std::filesystem::path& folder) {
  const auto has = [&](const char* name) { return is_file(folder / name); };
  return has("cameras.bin") || has("cameras.txt") || has("images.bin");
}

}  // namespace fluxgs
