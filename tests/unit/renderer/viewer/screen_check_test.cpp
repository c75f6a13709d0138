// The driver check of the app, with the scene and the picture that the app brings along.
#include "viewer/screen_check.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <webp/decode.h>
#include <webp/encode.h>
#include <nlohmann/json.hpp>

#include "camera/initial_view.h"
#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "platform/host/host_context.h"
#include "platform/host/offscreen_screen.h"
#include "tools/reference/reference_renderer.h"
#include "viewer/presenter.h"

namespace fluxgs::viewer {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Bytes = std::vector<std::byte>;

constexpr int kSize = 256;
const std::string kScene = FLUXGS_APP_ASSETS "/sample.glb",
                  kGolden = FLUXGS_APP_ASSETS "/sample.webp";

void expect_error(const Expected<std::string>& result, const std::string& part) {
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message(), HasSubstr(part));
}

/// The sample by the float64 reference.
Image<std::uint8_t> reference_picture() {
  const auto file = read_scene(std::filesystem::path(kScene));
  const camera::Navigation from =
      camera::initial_navigation(file->cloud, file->start, {kSize, kSize});
  return in_bytes(render_reference(file->cloud, camera::camera_of(from.view, kSize, kSize),
                                   {.near_plane = from.units.near_plane})
                      .color);
}

void write_golden(const Image<std::uint8_t>& image) {
  WebPConfig config;
  WebPPicture picture;
  WebPMemoryWriter writer;
  ASSERT_TRUE(WebPConfigInit(&config) && WebPConfigLosslessPreset(&config, 9) &&
              WebPPictureInit(&picture));
  WebPMemoryWriterInit(&writer);
  picture.use_argb = 1;
  picture.width = image.width;
  picture.height = image.height;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  ASSERT_TRUE(WebPPictureImportRGB(&picture, image.pixels.data(), 3 * image.width));
  ASSERT_TRUE(WebPEncode(&config, &picture));
  std::ofstream(kGolden, std::ios::binary)
      .write(reinterpret_cast<const char*>(writer.mem), static_cast<std::streamsize>(writer.size));
  WebPPictureFree(&picture);
  WebPMemoryWriterClear(&writer);
}

/// FLUXGS_UPDATE_PINS=1 writes the picture anew. Other C libraries may round a value otherwise.
TEST(ScreenCheck, TheGoldenPictureIsThatOfTheReference) {
  const Image<std::uint8_t> expected = reference_picture();
  if (std::getenv("FLUXGS_UPDATE_PINS") != nullptr) write_golden(expected);
  const Bytes file = *read_file(kGolden);
  std::vector<std::uint8_t> golden(expected.pixels.size());
  ASSERT_TRUE(WebPDecodeRGBInto(reinterpret_cast<const std::uint8_t*>(file.data()), file.size(),
                                golden.data(), golden.size(), 3 * kSize));
  std::size_t unlike = 0;
  for (std::size_t i = 0; i < golden.size(); ++i) {
    ASSERT_LE(std::abs(golden[i] - expected.pixels[i]), 1) << i;
    unlike += golden[i] != expected.pixels[i];
  }
  EXPECT_LE(unlike, golden.size() / 1000);
}

class ScreenCheckTest : public testing::TestWithParam<host::HostGl> {
 protected:
  void SetUp() override {
    if (const auto context = host::HostContext::create(GetParam()); !context)
      GTEST_SKIP() << context.error().message();
    screen_ = host::make_offscreen_screen(GetParam());
  }
  Expected<std::string> check(const Bytes& scene, const Bytes& golden,
                              const std::string& known = {}) {
    return check_driver_of(*screen_, scene, golden, known);
  }

  std::unique_ptr<Screen> screen_;
  Bytes scene_ = *read_file(kScene), golden_ = *read_file(kGolden);
};

TEST_P(ScreenCheckTest, EveryDesktopDrawsTheSampleRight) {
  const auto done = check(scene_, golden_);
  ASSERT_TRUE(done) << done.error().message();
  std::printf("%-7s %s\n", std::string(host::name(GetParam())).c_str(), done->c_str());
  const auto json = nlohmann::json::parse(*done);
  EXPECT_EQ(json["right"], true);
  EXPECT_THAT(json["limits"], IsEmpty());
  EXPECT_GE(json["psnr"].get<double>(), 50);
}

TEST_P(ScreenCheckTest, ADriverThatIsKnownIsNotCheckedAgain) {
  ASSERT_TRUE(screen_->make_context());
  const gl::Capabilities& driver = screen_->api()->capabilities;
  const auto done = check({}, {}, driver.renderer + ", " + driver.version);
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_THAT(*done, IsEmpty());
}

TEST_P(ScreenCheckTest, AnotherPictureIsNotRight) {
  const std::vector<std::uint8_t> dark(std::size_t{3} * kSize * kSize);
  std::uint8_t* packed = nullptr;
  const std::size_t size = WebPEncodeLosslessRGB(dark.data(), kSize, kSize, 3 * kSize, &packed);
  const auto bytes = std::as_bytes(std::span(packed, size));
  const auto done = check(scene_, {bytes.begin(), bytes.end()});
  WebPFree(packed);
  ASSERT_TRUE(done) << done.error().message();
  const auto json = nlohmann::json::parse(*done);
  EXPECT_EQ(json["right"], false);
  EXPECT_THAT(json["faults"].front().get<std::string>(), HasSubstr("dB from the golden one"));
}

TEST_P(ScreenCheckTest, BrokenFilesAreNamed) {
  expect_error(check(Bytes(100), golden_), "scene of the driver check");
  expect_error(check(scene_, {}), "golden picture: expected a WebP image");
  expect_error(check(scene_, Bytes(1000)), "golden picture: expected a WebP image");
  expect_error(check(scene_, {golden_.begin(), golden_.end() - 500}),
               "golden picture: is a damaged");
}

TEST_P(ScreenCheckTest, LimitsHoldForEveryContext) {
  Presenter presenter(std::move(screen_));
  presenter.set_limits({.no_gpu_sort = true,
                        .no_vertex_storage = true,
                        .no_float_targets = true,
                        .no_compute = true});
  for (int round = 0; round < 2; ++round) {
    const auto device = presenter.device();
    ASSERT_TRUE(device) << device.error().message();
    const gl::Api& api = *presenter.screen().api();
    EXPECT_TRUE((*device)->quirks().gpu_sort_fails);
    EXPECT_EQ(api.capabilities.max_vertex_storage_blocks, 0);
    EXPECT_FALSE(api.capabilities.compute);
    EXPECT_EQ(render::accurate_accumulation(api.capabilities), render::Accumulation::direct);
    presenter.lose_context();
  }
  presenter.set_limits({});
  const auto free = presenter.device();
  ASSERT_TRUE(free);
  EXPECT_FALSE((*free)->quirks().gpu_sort_fails);
}

TEST(DriverLimits, AreKnownByTheirNames) {
  const render::DriverLimits all{true, true, true, true};
  std::string names;
  for (const std::string& name : all.names()) names += name + " ";
  EXPECT_EQ(render::limits_named(names), all);
  EXPECT_EQ(render::limits_named("no_float_targets of_another"),
            render::DriverLimits{.no_float_targets = true});
  EXPECT_EQ(render::limits_named(""), render::DriverLimits());
}

INSTANTIATE_TEST_SUITE_P(Gl, ScreenCheckTest,
                         testing::Values(host::HostGl::egl, host::HostGl::osmesa,
                                         host::HostGl::angle),
                         [](const auto& of) { return std::string(host::name(of.param)); });

}  // namespace
}  // namespace fluxgs::viewer
