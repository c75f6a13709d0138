// transforms.json: the flavours that exist, and everything that can be wrong with them.
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "test_files.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

using namespace test;
using Json = nlohmann::ordered_json;

const Json kIdentity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};

Json frame(const std::string& path, const Json& matrix = kIdentity) {
  return {{"file_path", path}, {"transform_matrix", matrix}};
}

/// A data set of one 16×12 image images/a.png, with a focal length and no distortion.
Json one_frame() { return {{"fl_x", 20.0}, {"frames", Json::array({frame("images/a.png")})}}; }

Expected<Dataset> load(const Json& json, const LoadOptions& options = {}) {
  const TempFolder folder;
  write_text(folder.path() / "transforms.json", json.dump());
  write_image(folder.path() / "images" / "a.png", pattern(16, 12));
  write_image(folder.path() / "images" / "b.png", pattern(32, 12));
  return load_dataset(folder.path(), options);
}

Camera camera_of(const Json& json) {
  const auto data = load(json);
  EXPECT_TRUE(data) << data.error().message();
  return data ? data->train.at(0).camera : Camera{};
}

TEST(Transforms, PoseIsConvertedToOpenCvAxes) {
  Json json = one_frame();
  // A camera at (1, 2, 3) whose OpenGL axes are the world's: it looks along −z, up is +y.
  json["frames"][0]["transform_matrix"] = {{1, 0, 0, 1}, {0, 1, 0, 2}, {0, 0, 1, 3}, {0, 0, 0, 1}};
  const Camera camera = camera_of(json);
  EXPECT_EQ(camera.name, "a.png");
  EXPECT_EQ(camera.center(), glm::dvec3(1, 2, 3));
  EXPECT_EQ(camera.forward(), glm::dvec3(0, 0, -1));
  // A point above the axis is above the image's centre: y down.
  const glm::dvec3 p = camera.rotation * glm::dvec3(1, 3, -7) + camera.translation;
  EXPECT_EQ(p, glm::dvec3(0, -1, 10));
}

TEST(Transforms, UniformScaleOfAPoseIsDropped) {
  Json json = one_frame();
  json["frames"][0]["transform_matrix"] = {{0, -3, 0, 1}, {3, 0, 0, 2}, {0, 0, 3, 3}};
  const Camera camera = camera_of(json);
  EXPECT_LT(glm::distance(camera.center(), glm::dvec3(1, 2, 3)), 1e-14);
  EXPECT_NEAR(glm::determinant(camera.rotation), 1, 1e-14);
  EXPECT_NEAR(glm::length(camera.rotation[0]), 1, 1e-14);
}

TEST(Transforms, RoundedRotationsBecomeRotations) {
  Json json = one_frame();
  json["frames"][0]["transform_matrix"] = {
      {0.867, -0.5, 0, 1}, {0.5, 0.865, 0, 2}, {0, 0.001, 1, 3}, {0, 0, 0, 1}};
  const glm::dmat3 r = camera_of(json).rotation;
  const glm::dmat3 unit = r * glm::transpose(r);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(unit[i][j], i == j, 1e-14);
}

TEST(Transforms, IntrinsicsOfAnotherResolutionAreScaledEachWay) {
  Json json = one_frame();
  json.update({{"w", 160}, {"h", 60}, {"fl_x", 200.0}, {"fl_y", 90.0}, {"cx", 75.0}, {"cy", 31.0}});
  const Camera camera = camera_of(json);
  EXPECT_EQ(camera.width, 16);
  EXPECT_DOUBLE_EQ(camera.fx, 20);
  EXPECT_DOUBLE_EQ(camera.fy, 18);
  EXPECT_DOUBLE_EQ(camera.cx, 7.5);
  EXPECT_DOUBLE_EQ(camera.cy, 6.2);
}

TEST(Transforms, FieldOfViewAndDefaults) {
  Json json = one_frame();
  json.erase("fl_x");
  json["camera_angle_x"] = std::numbers::pi / 2;
  Camera camera = camera_of(json);
  EXPECT_NEAR(camera.fx, 8, 1e-12);
  EXPECT_NEAR(camera.fy, 8, 1e-12) << "square pixels";
  EXPECT_EQ(camera.cx, 8);
  EXPECT_EQ(camera.cy, 6);
  json["camera_angle_y"] = 2 * std::atan(6.0 / 9.0);
  EXPECT_NEAR(camera_of(json).fy, 9, 1e-12);
  json["fl_x"] = 11.0;  // instant-ngp: pixels win over angles
  EXPECT_EQ(camera_of(json).fx, 11);
}

TEST(Transforms, FramesOverrideTheFile) {
  Json json = one_frame();
  json.update({{"fl_y", 21.0}, {"cx", 7.0}, {"cy", 5.0}, {"w", 16}, {"h", 12}, {"k1", 0.05}});
  json["frames"].push_back(frame("images/b.png"));
  json["frames"][1].update({{"fl_x", 40.0}, {"cx", 15.0}, {"w", 32}, {"k1", 0.0}});
  const auto data = load(json, {.test_every = 0});
  ASSERT_TRUE(data) << data.error().message();
  const Camera& b = data->train.at(1).camera;
  EXPECT_EQ(b.width, 32);
  EXPECT_EQ(b.fx, 40);
  EXPECT_EQ(b.fy, 40) << "a frame's own fl_x is not paired with the file's fl_y";
  EXPECT_EQ(b.cx, 15);
  EXPECT_EQ(b.cy, 5);
  EXPECT_NE(data->train.at(0).camera.fx, 20) << "the first frame is still undistorted";
}

TEST(Transforms, AngleOfAFrameWinsOverPixelsOfTheFile) {
  Json json = one_frame();
  json["frames"][0]["camera_angle_x"] = std::numbers::pi / 2;
  EXPECT_NEAR(camera_of(json).fx, 8, 1e-12);
}

TEST(Transforms, ImagesAreFoundAsTheyAreUsuallyNamed) {
  for (const char* name : {"images/a.png", "./images/a.png", "images/a", "a.png", "a",
                           "/home/somebody/project/images/a.png", "..\\data\\images\\a.png"}) {
    Json json = one_frame();
    json["frames"][0]["file_path"] = name;
    const auto data = load(json);
    ASSERT_TRUE(data) << name << ": " << data.error().message();
    EXPECT_EQ(data->train.at(0).camera.name, "a.png");
  }
}

TEST(Transforms, APathWithoutExtensionIsAPngFirst) {
  const TempFolder folder;
  Json json = one_frame();
  json["frames"][0]["file_path"] = "images/a";
  write_text(folder.path() / "transforms.json", json.dump());
  write_image(folder.path() / "images" / "a.png", pattern(16, 12));
  write_text(folder.path() / "images" / "a.jpg", "");
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.at(0).camera.name, "a.png");
}

TEST(Transforms, MissingImagesAreSkippedWithOneWarning) {
  Json json = one_frame();
  for (const char* name : {"images/x.png", "images/y.png"}) json["frames"].push_back(frame(name));
  // Frames without an image are not looked at further.
  json["frames"].push_back({{"file_path", "images/z.png"}});
  const auto data = load(json);
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->skipped_images, 3U);
  EXPECT_THAT(data->warnings,
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("3 of 4 frames"),
                                                  testing::HasSubstr("images/x.png")),
                                   testing::HasSubstr("one image only")));
}

TEST(Transforms, EveryEighthFrameByFileNameIsForTesting) {
  const TempFolder folder;
  Json json = {{"fl_x", 20.0}, {"frames", Json::array()}};
  for (int i = 9; i >= 0; --i) {
    json["frames"].push_back(frame(fmt::format("{}.png", i)));
    write_image(folder.path() / fmt::format("{}.png", i), pattern(16, 12, 3, i));
  }
  write_text(folder.path() / "transforms.json", json.dump());
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  ASSERT_EQ(data->test.size(), 2U);
  EXPECT_EQ(data->test[0].camera.name, "0.png");
  EXPECT_EQ(data->test[1].camera.name, "8.png");
  EXPECT_EQ(data->train.size(), 8U);
}

TEST(Transforms, TrainAndTestFilesAreTheSplit) {
  const TempFolder folder;
  for (const char* split : {"train", "test", "val"}) {
    Json json = {{"camera_angle_x", 1.0}, {"frames", Json::array()}};
    for (int i = 0; i < 3; ++i) {
      json["frames"].push_back(frame(fmt::format("./{}/r_{}", split, i)));
      write_image(folder.path() / split / fmt::format("r_{}.png", i), pattern(16, 12, 4, i));
    }
    write_text(folder.path() / fmt::format("transforms_{}.json", split), json.dump());
  }
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 3U);
  EXPECT_EQ(data->test.size(), 3U);
  EXPECT_THAT(data->test[0].path, testing::EndsWith("test/r_0.png"));
  remove_file(folder.path() / "transforms_test.json");
  const auto without = load_dataset(folder.path(), {.test_every = 3});
  ASSERT_TRUE(without);
  EXPECT_EQ(without->train.size(), 2U);
  EXPECT_EQ(without->test.size(), 1U);
}

TEST(Transforms, NerfstudioPointsAreRead) {
  const TempFolder folder;
  Json json = one_frame();
  json["ply_file_path"] = "sparse_pc.ply";
  json["applied_transform"] = {{0, 1, 0, 0}, {1, 0, 0, 0}, {0, 0, -1, 0}};
  write_text(folder.path() / "transforms.json", json.dump());
  write_image(folder.path() / "images" / "a.png", pattern(16, 12));
  const auto missing = load_dataset(folder.path(), {});
  ASSERT_TRUE(missing);
  EXPECT_THAT(missing->warnings, testing::Contains(testing::HasSubstr("sparse_pc.ply")));

  const std::string properties =
      "property float x\nproperty float y\nproperty float z\nproperty uint8 red\n"
      "property uint8 green\nproperty uint8 blue\nend_header\n";
  const std::string ascii = "ply\nformat ascii 1.0\ncomment x\nelement vertex 2\n" + properties;
  write_text(folder.path() / "sparse_pc.ply", ascii + "1 2 3 4 5 6\nnan 0 0 0 0 0\n");
  const auto text = load_dataset(folder.path(), {});
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_THAT(text->points, testing::ElementsAre(glm::vec3(1, 2, 3)));
  EXPECT_THAT(text->point_colors, testing::ElementsAre(glm::u8vec3(4, 5, 6)));
  EXPECT_EQ(text->warnings.size(), 2U);

  Bytes bytes;
  bytes.add(-1.5F).add(2.5F).add(3.5F).add<std::uint8_t>(7).add<std::uint8_t>(8).add<std::uint8_t>(
      9);
  const std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" + properties + bytes.text;
  write_text(folder.path() / "sparse_pc.ply", binary);
  const auto read = load_dataset(folder.path(), {});
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_THAT(read->points, testing::ElementsAre(glm::vec3(-1.5, 2.5, 3.5)));
  EXPECT_THAT(read->point_colors, testing::ElementsAre(glm::u8vec3(7, 8, 9)));

  for (const std::string& whole : {binary, ascii + "1 2 3 4 5 6\n1 2 3 4 5 6"})
    for (std::size_t length = 0; length + 1 < whole.size(); ++length) {
      write_text(folder.path() / "sparse_pc.ply", whole.substr(0, length));
      expect_failure(load_dataset(folder.path(), {}), "sparse_pc.ply");
    }
  write_text(folder.path() / "sparse_pc.ply",
             "ply\nformat ascii 1.0\nelement vertex 99999999999\n" + properties);
  expect_failure(load_dataset(folder.path(), {}), "sparse_pc.ply", "99999999999 \"vertex\"");
}

/// What loading says after a change to a good file.
template <class Change>
Expected<Dataset> load_changed(Change change) {
  Json json = one_frame();
  change(json);
  return load(json);
}

TEST(TransformsBadInput, PosesAreNamedByFrame) {
  const auto with_matrix = [](const Json& matrix) {
    return load_changed([&](Json& j) {
      j["frames"].insert(j["frames"].begin(), frame("images/b.png"));
      j["frames"][1]["transform_matrix"] = matrix;
    });
  };
  EXPECT_TRUE(with_matrix(kIdentity));
  const char* field = "frame 1: transform_matrix";
  expect_failure(with_matrix(nullptr), "transforms.json", field);
  expect_failure(with_matrix({1, 2, 3}), field);
  expect_failure(with_matrix({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), field);
  expect_failure(with_matrix({{"1", 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}), field);
  // Null is what most writers make of NaN: tracking was lost.
  EXPECT_EQ(with_matrix({{1, 0, 0, 0}, {0, 1, 0, nullptr}, {0, 0, 1, 0}})->skipped_images, 1u);
  expect_failure(with_matrix({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}}), field, "right-handed");
  expect_failure(with_matrix({{1, 0.3, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}), field, "shear");
  expect_failure(with_matrix({{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}}), field);
  expect_failure(with_matrix({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 1, 1}}), field);
  expect_failure(with_matrix({{1e308, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1e-308, 0}}), field);
}

TEST(TransformsBadInput, OneBadFrameOfManyIsLeftOut) {
  for (const std::string change : {"matrix", "path", "twice"}) {
    const TempFolder folder;
    Json json = {{"fl_x", 20.0}, {"frames", Json::array()}};
    for (int i = 0; i < 4; ++i) {
      json["frames"].push_back(frame(fmt::format("images/{}.png", i)));
      write_image(folder.path() / "images" / fmt::format("{}.png", i), pattern(16, 12));
    }
    Json& bad = json["frames"][2];
    if (change == "matrix") bad["transform_matrix"] = {{0, 0}};
    if (change == "path") bad.erase("file_path");
    if (change == "twice") bad["file_path"] = "images/0.png";
    write_text(folder.path() / "transforms.json", json.dump());
    const auto data = load_dataset(folder.path(), {.test_every = 0});
    ASSERT_TRUE(data) << change << data.error().message();
    EXPECT_EQ(data->train.size(), 3u) << change;
    EXPECT_EQ(data->skipped_images, 1u) << change;
    EXPECT_THAT(data->warnings, testing::Contains(testing::HasSubstr("is left out"))) << change;
  }
}

TEST(TransformsBadInput, FieldsAreNamed) {
  expect_failure(load_changed([](Json& j) { j.erase("fl_x"); }), "fl_x");
  expect_failure(load_changed([](Json& j) { j["fl_x"] = "20"; }), "fl_x", "number");
  expect_failure(load_changed([](Json& j) { j["fl_x"] = -20; }), "frame 0", "focal length");
  expect_failure(load_changed([](Json& j) { j["fl_x"] = 0; }), "focal length");
  expect_failure(load_changed([](Json& j) { j["frames"][0]["cx"] = Json::array(); }), "frame 0: cx",
                 "number");
  expect_failure(load_changed([](Json& j) { j["w"] = 0; }), "w, h");
  expect_failure(load_changed([](Json& j) { j["frames"][0]["camera_angle_x"] = 3.2; }),
                 "frame 0: camera_angle_x: 3.2", "radians");
  expect_failure(load_changed([](Json& j) { j["frames"][0]["camera_angle_x"] = 60; }), "degrees?");
  expect_failure(load_changed([](Json& j) { j["k1"] = nullptr; }), "k1", "number");
  expect_failure(load_changed([](Json& j) { j["k1"] = 1e200; }), "a.png", "distortion");
  expect_failure(load_changed([](Json& j) { j["camera_model"] = "EQUIRECTANGULAR"; }),
                 "camera_model", "EQUIRECTANGULAR", "OPENCV");
  expect_failure(load_changed([](Json& j) { j["ftheta_p0"] = 0.5; }), "ftheta_p0");
  expect_failure(load_changed([](Json& j) { j["frames"][0].erase("file_path"); }),
                 "frame 0: file_path");
  expect_failure(load_changed([](Json& j) { j["frames"][0]["file_path"] = 7; }), "file_path");
  expect_failure(load_changed([](Json& j) { j["frames"][0] = 7; }), "frame 0");
  expect_failure(load_changed([](Json& j) { j["frames"].push_back(j["frames"][0]); }), "a.png",
                 "listed twice");
  expect_failure(load_changed([](Json& j) { j["frames"] = Json::array(); }), "no training images",
                 "frames: the list is empty");
  expect_failure(load_changed([](Json& j) { j["cx"] = -500, j["k1"] = 0.5, j["k2"] = -3; }),
                 "principal point: -500", "16x12", "check cx");
  expect_failure(load_changed([](Json& j) { j["frames"][0]["file_path"] = "nowhere.png"; }),
                 "no training images", "1 left out");
  expect_failure(load_changed([](Json& j) { j.erase("frames"); }), "transforms.json: frames");
  expect_failure(load_changed([](Json& j) { j["frames"] = 3; }), "frames");
}

TEST(TransformsBadInput, WhatIsNoJsonIsSaid) {
  const TempFolder folder;
  write_image(folder.path() / "images" / "a.png", pattern(16, 12));
  const fs::path file = folder.path() / "transforms.json";
  const std::string whole = one_frame().dump();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write_text(file, whole.substr(0, length));
    expect_failure(load_dataset(folder.path(), {}), "transforms.json");
  }
  const auto error_of = [&](const std::string& text) {
    write_text(file, text);
    return load_dataset(folder.path(), {}).error().message();
  };
  EXPECT_THAT(error_of(""), testing::HasSubstr("is empty"));
  EXPECT_THAT(error_of(" \n"), testing::HasSubstr("is empty"));
  EXPECT_THAT(error_of("{\n \"frames\": [\n  7,,\n]}"), testing::HasSubstr("line 3, column 5"));
  EXPECT_THAT(error_of("{\n \"frames\": ["), testing::HasSubstr("ends in line 2"));
  EXPECT_THAT(error_of(std::string("\xff\xfe{\0}\0", 6)), testing::HasSubstr("UTF-16"));
  EXPECT_THAT(error_of(std::string("{\0}\0", 4)), testing::HasSubstr("UTF-16"));
  for (const std::string& text :
       {std::string("[]"), std::string("7"), std::string("{\"fl_x\": NaN, \"frames\": []}"),
        std::string("{\"fl_x\": 1e999, \"frames\": []}"), std::string(100'000, '[')}) {
    write_text(file, text);
    expect_failure(load_dataset(folder.path(), {}), "transforms.json");
  }
}

TEST(TransformsBadInput, ImagesAreNamed) {
  const TempFolder folder;
  write_text(folder.path() / "transforms.json", one_frame().dump());
  write_text(folder.path() / "images" / "a.png", "");
  expect_failure(load_dataset(folder.path(), {}), "images/a.png", "is empty");
  write_image(folder.path() / "images" / "a.png", pattern(16, 12));
  const std::string whole = read_all(folder.path() / "images" / "a.png");
  write_text(folder.path() / "images" / "a.png", whole.substr(0, whole.size() - 20));
  expect_failure(load_dataset(folder.path(), {}), "images/a.png", "truncated");
}

}  // namespace
}  // namespace fluxgs
