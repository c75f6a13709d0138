// A small COLMAP model, written in both of COLMAP's formats.
#pragma once

#include "test_files.h"

namespace fluxgs::test {

struct TinyCamera {
  std::uint32_t id = 1;
  int model = 1;
  std::string model_name = "PINHOLE";
  std::uint64_t width = 16, height = 12;
  std::vector<double> parameters{20, 21, 8.5, 6.25};
};
struct TinyImage {
  std::string name;
  std::uint32_t camera_id = 1;
  std::vector<double> pose{1, 0, 0, 0, 0, 0, 0};  // quaternion wxyz, translation
  int observations = 2;
};
struct TinyModel {
  std::vector<TinyCamera> cameras{TinyCamera{}};
  std::vector<TinyImage> images;
  std::vector<std::vector<double>> points{{1, 2, 3}, {-4, 5.5, 6}, {0.125, 7, -8}};
};

/// Ten images a.png … j.png.
inline TinyModel ten_images() {
  TinyModel model;
  for (int i = 0; i < 10; ++i)
    model.images.push_back({.name = fmt::format("{}.png", static_cast<char>('a' + i)),
                            .pose = {0.5 + i, 0.25, -0.125 * i, 1, 0.5 * i, 2, -3}});
  return model;
}

inline void write_binary(const fs::path& folder, const TinyModel& model) {
  Bytes cameras, images, points;
  cameras.add<std::uint64_t>(model.cameras.size());
  for (const auto& c : model.cameras) {
    cameras.add(c.id).add<std::int32_t>(c.model).add(c.width).add(c.height);
    for (const double p : c.parameters) cameras.add(p);
  }
  images.add<std::uint64_t>(model.images.size());
  std::uint32_t id = 1;
  for (const auto& i : model.images) {
    images.add(id++);
    for (const double p : i.pose) images.add(p);
    images.add(i.camera_id)
        .add_name(i.name)
        .add<std::uint64_t>(static_cast<std::uint64_t>(i.observations));
    for (int k = 0; k < i.observations; ++k)
      images.add(1.5 * k).add(2.5 * k).add<std::int64_t>(k == 0 ? -1 : k);
  }
  points.add<std::uint64_t>(model.points.size());
  std::uint64_t point_id = 1;
  for (const auto& p : model.points) {
    points.add(point_id++).add(p[0]).add(p[1]).add(p[2]);
    points.add<std::uint8_t>(10).add<std::uint8_t>(20).add<std::uint8_t>(30).add(0.5);
    points.add<std::uint64_t>(1).add<std::int32_t>(1).add<std::int32_t>(0);
  }
  write_text(folder / "cameras.bin", cameras.text);
  write_text(folder / "images.bin", images.text);
  write_text(folder / "points3D.bin", points.text);
}

inline void write_text_model(const fs::path& folder, const TinyModel& model) {
  std::string cameras =
      fmt::format("# Camera list\n# Number of cameras: {}\n", model.cameras.size());
  for (const auto& c : model.cameras) {
    cameras += fmt::format("{} {} {} {}", c.id, c.model_name, c.width, c.height);
    for (const double p : c.parameters) cameras += fmt::format(" {}", p);
    cameras += "\n";
  }
  std::string images =
      fmt::format("# Number of images: {}, mean observations per image: 2\n", model.images.size());
  int id = 1;
  for (const auto& i : model.images) {
    images += fmt::format("{}", id++);
    for (const double p : i.pose) images += fmt::format(" {}", p);
    images += fmt::format(" {} {}\n", i.camera_id, i.name);
    for (int k = 0; k < i.observations; ++k)
      images += fmt::format("{} {} {} ", 1.5 * k, 2.5 * k, k == 0 ? -1 : k);
    images += "\n";
  }
  std::string points =
      fmt::format("# Number of points: {}, mean track length: 1\n", model.points.size());
  int point_id = 1;
  for (const auto& p : model.points)
    points += fmt::format("{} {} {} {} 10 20 30 0.5 1 0\n", point_id++, p[0], p[1], p[2]);
  write_text(folder / "cameras.txt", cameras);
  write_text(folder / "images.txt", images);
  write_text(folder / "points3D.txt", points);
}

/// images/ with an image for every image of the model.
inline void write_views(const fs::path& folder, const TinyModel& model) {
  int phase = 0;
  for (const auto& i : model.images)
    write_image(folder / "images" / i.name,
                pattern(static_cast<int>(model.cameras[0].width),
                        static_cast<int>(model.cameras[0].height), 3, phase++));
}

/// A complete data set in sparse/0 and images/.
inline void write_dataset(const fs::path& folder, const TinyModel& model) {
  write_binary(folder / "sparse" / "0", model);
  write_views(folder, model);
}

}  // namespace fluxgs::test
