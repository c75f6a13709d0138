// COLMAP data sets: both formats, and everything that can be wrong with them.
#include <limits>

#include "tiny_colmap.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

using namespace test;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> names(const std::vector<View>& views) {
  std::vector<std::string> result;
  for (const View& view : views) result.push_back(view.camera.name);
  return result;
}

TEST(Colmap, EveryEighthImageByNameIsForTesting) {
  const TempFolder folder;
  auto model = ten_images();
  std::ranges::reverse(model.images);  // The order in the file does not matter.
  write_dataset(folder.path(), model);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->kind, "COLMAP");
  EXPECT_THAT(names(data->test), testing::ElementsAre("a.png", "i.png"));
  EXPECT_THAT(names(data->train), testing::ElementsAre("b.png", "c.png", "d.png", "e.png", "f.png",
                                                       "g.png", "h.png", "j.png"));
  const auto all = load_dataset(folder.path(), {.test_every = 0});
  ASSERT_TRUE(all);
  EXPECT_EQ(all->train.size(), 10U);
  EXPECT_TRUE(all->test.empty());
}

TEST(Colmap, PosesIntrinsicsPixelsAndPointsArriveAsStored) {
  const TempFolder folder;
  TinyModel model;
  // A quarter turn about z with a quaternion of length √2·3.
  model.images = {{.name = "x.png", .pose = {3, 0, 0, 3, 1, 2, 3}}};
  write_dataset(folder.path(), model);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  const Camera& camera = data->train.at(0).camera;
  const glm::dvec3 image_of_x = camera.rotation * glm::dvec3(1, 0, 0);
  EXPECT_NEAR(image_of_x.y, 1, 1e-15);
  EXPECT_EQ(camera.translation, glm::dvec3(1, 2, 3));
  EXPECT_EQ(camera.fx, 20);
  EXPECT_EQ(camera.fy, 21);
  EXPECT_EQ(camera.cx, 8.5);
  EXPECT_EQ(camera.cy, 6.25);
  EXPECT_EQ(data->train[0].rgb.pixels, pattern(16, 12).pixels);
  ASSERT_EQ(data->points.size(), 3U);
  EXPECT_EQ(data->points[1], glm::vec3(-4, 5.5, 6));
  EXPECT_EQ(data->point_colors[2], glm::u8vec3(10, 20, 30));
}

TEST(Colmap, ImagesWithoutTheirLinesOfPoints) {
  const TempFolder folder;
  auto model = ten_images();
  for (auto& image : model.images) image.observations = 0;
  write_text_model(folder.path() / "sparse" / "0", model);
  write_views(folder.path(), model);
  const fs::path file = folder.path() / "sparse" / "0" / "images.txt";
  std::string text = read_all(file);
  for (std::size_t at; (at = text.find("\n\n")) != std::string::npos;) text.erase(at, 1);
  write_text(file, text);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 10U);
  EXPECT_TRUE(data->warnings.empty());
}

TEST(Colmap, TextEqualsBinary) {
  const TempFolder folder;
  auto model = ten_images();
  model.cameras.push_back({7, 4, "OPENCV", 40, 30, {1.5, 2.5, 3, 4, 0.1, -0.2, 1e-3, 2e-17}});
  model.images[3].camera_id = 7;
  model.images[4].observations = 0;  // An empty second line
  write_binary(folder.path(), model);
  write_text_model(folder.path(), model);
  const auto binary = read_colmap_binary(folder.path());
  const auto text = read_colmap_text(folder.path());
  ASSERT_TRUE(binary) << binary.error().message();
  ASSERT_TRUE(text) << text.error().message();
  for (const auto& [id, lens] : binary->cameras) EXPECT_EQ(*lens, *text->cameras.at(id));
  EXPECT_EQ(binary->cameras.size(), text->cameras.size());
  ASSERT_EQ(binary->images.size(), text->images.size());
  for (std::size_t i = 0; i < binary->images.size(); ++i) {
    const ColmapImage &a = binary->images[i], &b = text->images[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.camera_id, b.camera_id);
    EXPECT_EQ(a.rotation, b.rotation);
    EXPECT_EQ(a.translation, b.translation);
    ASSERT_EQ(a.observations.size(), b.observations.size());
    for (std::size_t k = 0; k < a.observations.size(); ++k) {
      EXPECT_EQ(a.observations[k].pixel, b.observations[k].pixel);
      EXPECT_EQ(a.observations[k].point_id, b.observations[k].point_id);
    }
  }
  ASSERT_EQ(binary->points.size(), text->points.size());
  for (std::size_t i = 0; i < binary->points.size(); ++i) {
    EXPECT_EQ(binary->points[i].position, text->points[i].position);
    EXPECT_EQ(binary->points[i].color, text->points[i].color);
  }
}

TEST(Colmap, TextMayBeginWithAByteOrderMark) {
  const TempFolder folder;
  write_text_model(folder.path() / "sparse", ten_images());
  write_views(folder.path(), ten_images());
  const fs::path file = folder.path() / "sparse" / "cameras.txt";
  const std::string text = read_all(file);
  write_text(file, "\xef\xbb\xbf" + text);
  EXPECT_TRUE(load_dataset(folder.path(), {}));
  std::string wide = "\xff\xfe";
  for (const char c : text) (wide += c) += '\0';
  write_text(file, wide);
  expect_failure(load_dataset(folder.path(), {}), "cameras.txt", "UTF-16", "save it as UTF-8");
}

TEST(Colmap, TextTakesWindowsLineEnds) {
  const TempFolder folder;
  write_text(folder.path() / "cameras.txt", "1 SIMPLE_PINHOLE 16 12 20 8 6\r\n");
  write_text(folder.path() / "images.txt", "1 1 0 0 0 0 0 0 1 a.png\r\n\r\n");
  const auto model = read_colmap_text(folder.path());
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->images.at(0).name, "a.png");
  EXPECT_FALSE(model->has_points_file);
}

TEST(Colmap, CameraModels) {
  const auto lens_of = [](int id, std::vector<double> parameters) {
    const auto* model = find_camera_model(id);
    EXPECT_EQ(static_cast<std::size_t>(model->parameters), parameters.size());
    return make_colmap_lens(*model, 100, 80, parameters, "cameras.bin", "camera 1");
  };
  using Coefficients = decltype(Lens::distortion);
  EXPECT_EQ(lens_of(0, {9, 1, 2})->fy, 9);
  EXPECT_EQ(lens_of(1, {9, 8, 1, 2})->cy, 2);
  EXPECT_EQ(lens_of(2, {9, 1, 2, .1})->distortion, (Coefficients{.1}));
  EXPECT_EQ(lens_of(3, {9, 1, 2, .1, .2})->distortion, (Coefficients{.1, .2}));
  EXPECT_EQ(lens_of(4, {9, 8, 1, 2, .1, .2, .3, .4})->distortion, (Coefficients{.1, .2, .3, .4}));
  EXPECT_EQ(lens_of(6, {9, 8, 1, 2, .1, .2, .3, .4, .5, .6, .7, .8})->distortion,
            (Coefficients{.1, .2, .3, .4, .5, .6, .7, .8}));
  EXPECT_EQ(lens_of(5, {9, 8, 1, 2, .1, .2, .3, .4})->model, LensModel::kFisheye);
  EXPECT_EQ(lens_of(9, {9, 1, 2, .1, .2})->fy, 9);
  EXPECT_EQ(lens_of(7, {9, 8, 1, 2, .1})->model, LensModel::kFieldOfView);
  EXPECT_EQ(lens_of(10, std::vector<double>(12, .5))->distortion[7], .5);
  EXPECT_EQ(lens_of(11, std::vector<double>(16, .5))->distortion[11], .5);
  EXPECT_EQ(lens_of(12, {9, 1, 2, .1})->distortion, (Coefficients{.1}));
  EXPECT_EQ(lens_of(13, {9, 8, 1, 2, .1})->distortion, (Coefficients{.1}));
  EXPECT_EQ(lens_of(14, {9, 1, 2})->fy, 9);
  EXPECT_EQ(lens_of(15, {9, 8, 1, 2})->cy, 2);
  EXPECT_EQ(lens_of(16, {9, 8, 1, 2, .5, 1})->distortion, (Coefficients{.5, 1}));
  expect_failure(lens_of(17, {100, 80}), "cameras.bin", "camera 1", "EQUIRECTANGULAR");
  EXPECT_EQ(find_camera_model(99), nullptr);
}

/// What loading says after a change to a good model.
template <class Change>
Expected<Dataset> load_changed(Change change) {
  const TempFolder folder;
  auto model = ten_images();
  change(model);
  write_dataset(folder.path(), model);
  return load_dataset(folder.path(), {});
}

TEST(ColmapBadInput, ContradictionsAreNamed) {
  expect_failure(load_changed([](auto& m) { m.images[2].camera_id = 5; }), "images.bin",
                 "image \"c.png\"", "camera 5");
  expect_failure(load_changed([](auto& m) { m.images[2].name = "b.png"; }), "images.bin",
                 "image \"b.png\"", "listed twice");
  expect_failure(load_changed([](auto& m) { m.cameras.push_back(m.cameras[0]); }), "cameras.bin",
                 "camera 1", "twice");
  expect_failure(load_changed([](auto& m) { m.cameras[0].parameters[0] = -3; }), "cameras.bin",
                 "focal length");
  expect_failure(load_changed([](auto& m) { m.cameras[0].parameters[2] = kNaN; }),
                 "principal point");
  expect_failure(load_changed([](auto& m) { m.cameras[0].model = 77; }), "77");
  expect_failure(load_changed([](auto& m) { m.images.clear(); }), "no training images");
}

TEST(Colmap, ImagesWhosePosesAreLostAreLeftOut) {
  const auto data = load_changed([](auto& m) {
    m.images[1].pose[2] = kNaN;
    m.images[3].pose[5] = HUGE_VAL;
    m.images[4].pose = {0, 0, 0, 0, 1, 2, 3};
  });
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 7u);
  EXPECT_EQ(data->skipped_images, 3u);
  EXPECT_THAT(data->warnings, testing::ElementsAre(testing::HasSubstr("b.png, d.png, e.png")));
}

TEST(Colmap, StrayCamerasAndPointsAreLeftOut) {
  const auto change = [](double camera, double point) {
    return load_changed([&](auto& m) {
      for (std::size_t i = 0; i < m.images.size(); ++i)
        m.images[i].pose = {1, 0, 0, 0, 0.1 * static_cast<double>(i), 0, 0};
      m.images[5].pose[4] = camera;
      m.points = {{1, 2, 3}, {2, 1, 3}, {0, 0, 3}, {1, 1, 2}, {3, 3, 3}, {point, 0, 0}};
    });
  };
  const auto near = change(5, 1000);
  ASSERT_TRUE(near) << near.error().message();
  EXPECT_TRUE(near->warnings.empty());
  EXPECT_EQ(near->points.size(), 6u);
  const auto far = change(3000, 1e7);
  ASSERT_TRUE(far) << far.error().message();
  EXPECT_EQ(far->train.size() + far->test.size(), 9u);
  EXPECT_EQ(far->points.size(), 5u);
  EXPECT_THAT(far->warnings, testing::ElementsAre(testing::HasSubstr("most: f.png"),
                                                  testing::HasSubstr("most: 1")));
}

// The only image for testing, too.
TEST(Colmap, OneBadImageOfManyIsLeftOut) {
  const TempFolder folder;
  auto model = ten_images();
  model.images.resize(5);
  write_dataset(folder.path(), model);
  const fs::path image = folder.path() / "images" / "a.png";
  fs::resize_file(image, fs::file_size(image) - 20);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 4u);
  EXPECT_TRUE(data->test.empty());
  EXPECT_THAT(data->warnings, testing::ElementsAre(testing::HasSubstr("a.png")));
}

TEST(Colmap, CamerasThatNoImageUsesAreNotJudged) {
  const auto data = load_changed([](auto& m) {
    m.cameras.push_back({7, 1, "PINHOLE", 16, 12, {0, -1, kNaN, 6}});
    m.cameras.push_back({8, 17, "EQUIRECTANGULAR", 16, 12, {16, 12}});
  });
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_TRUE(data->warnings.empty());
}

TEST(Colmap, PointsMayBeEmptyOrPly) {
  const TempFolder folder;
  auto model = ten_images();
  write_views(folder.path(), model);
  const fs::path sparse = folder.path() / "sparse" / "0";
  write_text_model(sparse, model);
  write_text(sparse / "points3D.txt", "");
  EXPECT_EQ(load_dataset(folder.path(), {})->points.size(), 0u);
  remove_file(sparse / "points3D.txt");
  write_text(sparse / "points3D.ply",
             "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
             "property float z\nend_header\n1 2 3\n4 5 6\n");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->points.size(), 2u);
  EXPECT_TRUE(data->warnings.empty());
}

TEST(ColmapBadInput, SizesThatNoImageHas) {
  for (const std::uint64_t width : {std::uint64_t{0}, std::uint64_t{1} << 30, ~std::uint64_t{0}}) {
    const auto* model = find_camera_model(0);
    expect_failure(make_colmap_lens(*model, width, 10, {1, 1, 1}, "f", "camera 1"), "image size");
  }
}

TEST(Colmap, IntrinsicsAreScaledToTheImages) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  write_image(folder.path() / "images" / "d.png", pattern(8, 6));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  const Camera& camera = data->train.at(2).camera;
  EXPECT_EQ(camera.name, "d.png");
  EXPECT_EQ(camera.width, 8);
  EXPECT_DOUBLE_EQ(camera.fx, 10);
  EXPECT_DOUBLE_EQ(camera.cy, 3.125);
  EXPECT_TRUE(data->warnings.empty());
}

TEST(ColmapBadInput, ImageOfAnotherShapeThanItsCameraIsWarnedOf) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  write_image(folder.path() / "images" / "d.png", pattern(8, 8));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  ASSERT_EQ(data->warnings.size(), 1u);
  EXPECT_THAT(data->warnings[0],
              testing::AllOf(testing::HasSubstr("width to height differs from their camera's"),
                             testing::HasSubstr("d.png")));
}

TEST(ColmapBadInput, MissingImagesAreSkippedAndCounted) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  remove_file(folder.path() / "images" / "c.png");
  remove_file(folder.path() / "images" / "d.png");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->skipped_images, 2U);
  EXPECT_THAT(data->warnings, testing::ElementsAre(testing::HasSubstr("2 of 10 images")));
  for (const auto& image : ten_images().images) remove_file(folder.path() / "images" / image.name);
  expect_failure(load_dataset(folder.path(), {}), "no training images", "10 left out");
}

TEST(ColmapBadInput, ImageNamesThatNoFileHas) {
  const TempFolder folder;
  auto model = ten_images();
  write_dataset(folder.path(), model);
  model.images[0].name = std::string(100'000, 'x');
  model.images[1].name = "new\nline\x1b[31m";
  model.images[2].name = "/dev/zero";  // Would never end.
  write_binary(folder.path() / "sparse" / "0", model);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->skipped_images, 3U);
  EXPECT_LT(data->warnings.at(0).size(), 1000U);
}

TEST(ColmapBadInput, PointsThatAreNotFiniteAreDropped) {
  const TempFolder folder;
  auto model = ten_images();
  model.points = {{1, 2, 3}, {kNaN, 0, 0}, {0, 1e300, 0}, {4, 5, 6}};
  write_dataset(folder.path(), model);
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_THAT(data->points, testing::ElementsAre(glm::vec3(1, 2, 3), glm::vec3(4, 5, 6)));
  EXPECT_EQ(data->point_colors.size(), 2U);
  EXPECT_THAT(data->warnings, testing::ElementsAre(testing::HasSubstr("2 points")));
}

TEST(ColmapBadInput, PointsFileMayBeMissingTheOthersMayNot) {
  const TempFolder folder;
  write_dataset(folder.path(), ten_images());
  const fs::path model = folder.path() / "sparse" / "0";
  remove_file(model / "points3D.bin");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_THAT(data->warnings, testing::ElementsAre(testing::HasSubstr("points3D")));
  remove_file(model / "images.bin");
  expect_failure(load_dataset(folder.path(), {}), "images.bin");
}

TEST(ColmapBadInput, BinaryFilesCutAtAnyByteAreRefused) {
  const TempFolder folder;
  write_binary(folder.path(), ten_images());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = read_all(folder.path() / name);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      write_text(folder.path() / name, whole.substr(0, length));
      const auto model = read_colmap_model(folder.path());
      ASSERT_FALSE(model) << name << " cut to " << length;
      ASSERT_THAT(model.error().message(), testing::HasSubstr(name));
    }
    write_text(folder.path() / name, whole + "x");
    expect_failure(read_colmap_model(folder.path()), name, "too many");
    write_text(folder.path() / name, whole);
  }
  EXPECT_TRUE(read_colmap_model(folder.path()));
}

TEST(ColmapBadInput, TextFilesCutAtAnyByteNeverCrash) {
  const TempFolder folder;
  write_text_model(folder.path(), ten_images());
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    const std::string whole = read_all(folder.path() / name);
    std::size_t accepted = 0;
    for (std::size_t length = 0; length < whole.size(); ++length) {
      write_text(folder.path() / name, whole.substr(0, length));
      const auto model = read_colmap_model(folder.path());
      accepted += model.has_value();
      // A cut inside the last record's numbers cannot be told from a shorter number; a missing
      // record can, by the count in the opening comment.
      const std::size_t last_line = whole.rfind('\n', whole.size() - 2);
      // A missing line is one that was taken out
      const bool between_lines = length > 0 && whole[length - 1] == '\n';
      if (length > 60 && length + 60 < last_line && !between_lines) {
        ASSERT_FALSE(model) << name << " cut to " << length;
      }
    }
    EXPECT_LT(accepted, 150U) << name;
    write_text(folder.path() / name, whole);
  }
}

TEST(ColmapBadInput, BinaryFilesWithAnyByteChangedNeverCrash) {
  const TempFolder folder;
  write_binary(folder.path(), ten_images());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = read_all(folder.path() / name);
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string changed = whole;
      changed[at] = static_cast<char>(~changed[at]);
      write_text(folder.path() / name, changed);
      (void)read_colmap_model(folder.path());
    }
    write_text(folder.path() / name, whole);
  }
}

TEST(ColmapBadInput, HostileCountsAreRefusedBeforeAllocating) {
  const TempFolder folder;
  write_binary(folder.path(), ten_images());
  for (const char* name : {"cameras.bin", "images.bin", "points3D.bin"}) {
    const std::string whole = read_all(folder.path() / name);
    for (const std::uint64_t count :
         {~std::uint64_t{0}, std::uint64_t{1} << 40, std::uint64_t{1'000'000}}) {
      std::string changed = whole;
      std::memcpy(changed.data(), &count, sizeof count);
      write_text(folder.path() / name, changed);
      expect_failure(read_colmap_model(folder.path()), name, "promises", std::to_string(count));
    }
    write_text(folder.path() / name, whole);
  }
}

TEST(ColmapBadInput, TextLinesAreNamedByNumber) {
  const TempFolder folder;
  write_text_model(folder.path(), ten_images());
  const auto with = [&](const char* name, const std::string& text) {
    const std::string whole = read_all(folder.path() / name);
    write_text(folder.path() / name, text);
    auto model = read_colmap_text(folder.path());
    write_text(folder.path() / name, whole);
    return model;
  };
  expect_failure(with("cameras.txt", "1 PINHOLE 16 12 20 21 8.5\n"), "cameras.txt", "line 1",
                 "4 parameters");
  expect_failure(with("cameras.txt", "\n1 PINHOLE 16 12 20 21 8.5 6 9\n"), "line 2");
  EXPECT_EQ(with("cameras.txt", "1 PINHALL 16 12 20 21 8.5 6\n")->cameras.at(1).error().what,
            "unknown camera model \"PINHALL\"");
  expect_failure(with("cameras.txt", "1 PINHOLE -16 12 20 21 8.5 6\n"), "line 1");
  expect_failure(with("images.txt", "1 1 0 0 0 0 0 zero 1 a.png\n\n"), "images.txt", "line 1");
  expect_failure(with("images.txt", "1 1 0 0 0 0 0 0 1\n\n"), "NAME");
  expect_failure(with("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n1 2\n"), "line 2", "POINTS2D");
  expect_failure(with("points3D.txt", "1 0 0 0 256 0 0 0.5\n"), "points3D.txt", "line 1");
  expect_failure(with("points3D.txt", "# Number of points: 3\n1 0 0 0 25 0 0 0.5"),
                 "promises 3 records and has 1");
  EXPECT_THAT(with("points3D.txt", "# Number of points: 3\n1 0 0 0 25 0 0 0.5\n")->warnings,
              testing::ElementsAre(testing::HasSubstr("promises 3 records and has 1")));
}

}  // namespace
}  // namespace fluxgs
