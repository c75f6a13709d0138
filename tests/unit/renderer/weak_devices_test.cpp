// Devices that lack something, by masking what this machine's drivers say: a named fallback whose
// cost is known, or a refusal that says what is needed. More of the kind: renderer_test.cpp.
#include <gmock/gmock.h>

#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "image_fixture.h"
#include "render/ordered_splats.h"

namespace fluxgs::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// What the driver would say if it were an older one; the rest it is asked itself. One at a time.
struct Claim {
  std::string version = {};
  int major = 0, minor = 0;
  std::string renderer = {};
};
Claim claim;
decltype(gl::Api::GetString) driver_get_string = nullptr;
decltype(gl::Api::GetIntegerv) driver_get_integer = nullptr;

const GLubyte* GL_APIENTRY claimed_string(GLenum name) {
  const std::string& text = name == GL_VERSION ? claim.version : claim.renderer;
  const bool claims = (name == GL_VERSION || name == GL_RENDERER) && !text.empty();
  return claims ? reinterpret_cast<const GLubyte*>(text.c_str()) : driver_get_string(name);
}

void GL_APIENTRY claimed_integer(GLenum name, GLint* value) {
  if (name == GL_MAJOR_VERSION) {
    *value = claim.major;
  } else if (name == GL_MINOR_VERSION) {
    *value = claim.minor;
  } else {
    driver_get_integer(name, value);
  }
}

class WeakDevicesTest : public ImageTest {
 protected:
  /// The functions of this context by their names, as a platform's getProcAddress knows them.
  std::map<std::string, void*> functions() {
    std::map<std::string, void*> all;
#define FLUXGS_GL_BY_NAME(name) all["gl" #name] = reinterpret_cast<void*>(api().name);
    FLUXGS_GL_FUNCTIONS(FLUXGS_GL_BY_NAME)
    FLUXGS_GL_COMPUTE_FUNCTIONS(FLUXGS_GL_BY_NAME)
#undef FLUXGS_GL_BY_NAME
    return all;
  }

  std::string refusal(const std::map<std::string, void*>& functions) {
    const auto loaded = gl::load_api([&](const char* name) {
      const auto found = functions.find(name);
      return found == functions.end() ? nullptr : found->second;
    });
    return loaded ? "was loaded" : loaded.error().message();
  }

  std::string refusal_as(const Claim& older) {
    claim = older;
    driver_get_string = api().GetString;
    driver_get_integer = api().GetIntegerv;
    auto all = functions();
    all["glGetString"] = reinterpret_cast<void*>(claimed_string);
    all["glGetIntegerv"] = reinterpret_cast<void*>(claimed_integer);
    return refusal(all);
  }
};

TEST_P(WeakDevicesTest, OlderThanEs30IsRefused) {
  EXPECT_THAT(refusal_as({"OpenGL ES 2.0 V@415.0", 2, 0}),
              AllOf(HasSubstr("OpenGL ES 3.0 or desktop OpenGL 4.5 is needed"),
                    HasSubstr("\"OpenGL ES 2.0 V@415.0\"")));
  EXPECT_THAT(refusal_as({"4.1 Metal - 83", 4, 1}), HasSubstr("\"4.1 Metal - 83\""));
  EXPECT_THAT(refusal_as({"OpenGL ES 2.0", 0, 0}), HasSubstr("OpenGL ES 3.0 or"));

  auto all = functions();
  all["glDrawArrays"] = nullptr;
  EXPECT_THAT(refusal(all), AllOf(HasSubstr("glDrawArrays"), HasSubstr("OpenGL ES 3.0 is needed")));
  EXPECT_THAT(refusal({}), HasSubstr("OpenGL ES 3.0 is needed"));
}

TEST_P(WeakDevicesTest, WithoutComputeShadersItIsLoaded) {
  EXPECT_EQ(refusal_as({"OpenGL ES 3.0 V@415.0", 3, 0}), "was loaded");
  auto all = functions();
  all["glDispatchCompute"] = nullptr;
  EXPECT_EQ(refusal(all), "was loaded");
}

/// Lets the driver say less until the end of its life.
class Masked {
 public:
  explicit Masked(gl::Api& api) : api_(api), before_(api.capabilities) {}
  Masked(const Masked&) = delete;
  Masked& operator=(const Masked&) = delete;
  ~Masked() { api_.capabilities = before_; }
  gl::Capabilities& now() { return api_.capabilities; }

 private:
  gl::Api& api_;
  gl::Capabilities before_;
};

// Each layer is rounded to 8 bits. Tolerance: 35 dB on a haze of some 70 layers a pixel, 45 dB on
// an ordinary scene.
TEST_P(WeakDevicesTest, WithoutFloatTargetsLayersAreBlendedInBytes) {
  Masked driver(api());
  driver.now().half_float_targets = driver.now().float_targets = false;
  EXPECT_EQ(accurate(), Accumulation::direct);
  const auto weak = must(render::Renderer::create(api()));
  const auto psnr = [&](const char* label, const SplatCloud& cloud) {
    must(weak->upload(cloud));
    const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
    const RenderTarget target =
        must(RenderTarget::create(api(), camera.width, camera.height, TargetFormat::rgba8));
    EXPECT_FALSE(target.needs_resolve());
    must(weak->draw(camera, kRose, target));
    const Difference d =
        compare(must(weak->read(target)), render_reference(cloud, camera, kRose), true);
    print(label, d);
    return d.psnr;
  };
  SplatCloud cloud = random_cloud(6000, 1, 41);
  for (glm::vec3& c : cloud.sh_dc) c *= 0.5F;  // Colours above 1 are cut at every layer, too
  EXPECT_GE(psnr("no float targets", cloud), 45);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] += 1.5F;
    cloud.opacity_logits[i] = -3.0F + 0.25F * cloud.opacity_logits[i];
  }
  EXPECT_GE(psnr("no float targets, haze", cloud), 35);

  const auto refusal = [&](TargetFormat format, Accumulation accumulation) {
    const auto made = RenderTarget::create(api(), 8, 8, format, accumulation);
    return made ? std::string("was made") : made.error().message();
  };
  const auto half = HasSubstr("RGBA16F: " + driver.now().renderer + " cannot render to it");
  EXPECT_THAT(RenderTarget::create(api(), 8, 8, TargetFormat::rgba16f).error().message(),
              AllOf(half, HasSubstr("RGBA8 is possible")));
  EXPECT_THAT(refusal(TargetFormat::rgba8, Accumulation::half_float), half);
  EXPECT_THAT(refusal(TargetFormat::rgba8, Accumulation::single_float), HasSubstr("RGBA32F"));
}

// EXT_color_buffer_half_float alone. Tolerance: the 50 and 45 dB that the project promises.
TEST_P(WeakDevicesTest, WithHalfFloatTargetsOnlyLayersAreBlendedInThose) {
  Masked driver(api());
  driver.now().float_targets = false;
  EXPECT_EQ(accurate(), Accumulation::half_float);
  const SplatCloud cloud = random_cloud(3000, 1, 42);
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  must(renderer().upload(cloud));
  const ReferenceImage reference = render_reference(cloud, camera, kRose);
  for (const TargetFormat format : {TargetFormat::rgba16f, TargetFormat::rgba8}) {
    const bool bytes = format == TargetFormat::rgba8;
    const RenderTarget target =
        must(RenderTarget::create(api(), camera.width, camera.height, format));
    EXPECT_EQ(target.needs_resolve(), bytes);
    must(renderer().draw(camera, kRose, target));
    const Difference d = compare(must(renderer().read(target)), reference, bytes);
    print(bytes ? "half-float targets only, RGBA8" : "half-float targets only, RGBA16F", d);
    EXPECT_GE(d.psnr, bytes ? 45 : 50);
  }
}

void GL_APIENTRY disjoint_clock(GLenum name, GLint* value) {
  if (name == GL_GPU_DISJOINT_EXT)
    *value = GL_TRUE;
  else
    driver_get_integer(name, value);
}

TEST_P(WeakDevicesTest, TimesOfAClockThatWasSetAnewAreLeftOut) {
  if (!api().capabilities.is_es || !api().capabilities.timestamps) GTEST_SKIP();
  const auto timed = must(render::Renderer::create(api(), {.timestamps = true}));
  must(timed->upload(random_cloud(10, 0, 43)));
  const RenderTarget target = must(RenderTarget::create(api(), 8, 8, TargetFormat::rgba8));
  must(timed->draw(front_camera(8, 8, 2), {}, target));
  EXPECT_TRUE(must(timed->stats()).stages);
  driver_get_integer = std::exchange(api().GetIntegerv, disjoint_clock);
  const auto stats = timed->stats();
  api().GetIntegerv = driver_get_integer;
  EXPECT_EQ(must(stats).drawn, 10U);
  EXPECT_FALSE(must(stats).stages);
}

TEST_P(WeakDevicesTest, DriversOfMaliAreNotAskedForTimes) {
  claim = {.renderer = "Mali-G78"};
  driver_get_string = api().GetString;
  auto all = functions();
  all["glGetString"] = reinterpret_cast<void*>(claimed_string);
  const auto loaded = gl::load_api([&](const char* name) { return all[name]; });
  ASSERT_TRUE(loaded);
  EXPECT_FALSE((*loaded)->capabilities.timestamps);
  EXPECT_EQ((*loaded)->QueryCounter, nullptr);
  EXPECT_THAT((*loaded)->quirks.names(), testing::Contains("timer_queries_crash"));
}

GLint claimed_bits = 0;
void GL_APIENTRY claimed_query(GLenum, GLenum name, GLint* value) {
  if (name == GL_QUERY_COUNTER_BITS_EXT) *value = claimed_bits;
}

TEST_P(WeakDevicesTest, AClockWithoutDigitsIsNone) {
  if (!api().capabilities.timestamps) GTEST_SKIP();
  auto all = functions();
  for (const char* suffix : {"", "EXT"}) {
    all[std::string("glQueryCounter") + suffix] = reinterpret_cast<void*>(api().QueryCounter);
    all[std::string("glGetQueryObjectui64v") + suffix] =
        reinterpret_cast<void*>(api().GetQueryObjectui64v);
    all[std::string("glGetQueryiv") + suffix] = reinterpret_cast<void*>(claimed_query);
  }
  for (const GLint bits : {0, 36}) {
    claimed_bits = bits;
    const auto loaded = gl::load_api([&](const char* name) { return all[name]; });
    ASSERT_TRUE(loaded);
    EXPECT_EQ((*loaded)->capabilities.timestamps, bits > 0);
  }
}

TEST_P(WeakDevicesTest, SmallLimitsAreNamed) {
  Masked driver(api());
  driver.now().timestamps = false;
  const auto untimed = must(render::Renderer::create(api(), {.timestamps = true}));
  must(untimed->upload(random_cloud(10, 0, 43)));
  const RenderTarget target = must(RenderTarget::create(api(), 8, 8, TargetFormat::rgba8));
  must(untimed->draw(front_camera(8, 8, 2), {}, target));
  const render::FrameStats stats = must(untimed->stats());
  EXPECT_EQ(stats.drawn, 10U);
  EXPECT_FALSE(stats.stages);

  driver.now().max_work_groups_x = 2;
  EXPECT_THAT(untimed->upload(random_cloud(256, 0, 43)).error().message(),
              HasSubstr("it can hold 255"));
  driver.now().max_viewport_width = 100;
  EXPECT_THAT(RenderTarget::create(api(), 101, 8, TargetFormat::rgba8).error().message(),
              HasSubstr("1×1 to 100×"));
  driver.now().max_texture_size = 64;  // rows, of which one holds 1024 splats of 32 bytes
  auto ordered = must(render::OrderedSplats::create(api(), 128, render::SplatPrecision::full));
  const auto reserved = ordered.reserve(api(), 1024 * 65);
  ASSERT_FALSE(reserved);
  EXPECT_THAT(reserved.error().message(), AllOf(HasSubstr("65 rows"), HasSubstr("offers 64")));
  driver.now().max_compute_storage_blocks = 0;
  const auto refused = render::Renderer::create(api());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS"));
}

// The GPUs of phones sort by fewer bits.
TEST_P(WeakDevicesTest, TilersTakeShortKeys) {
  gl::Capabilities phone = api().capabilities;
  for (const char* name : {"Adreno (TM) 750", "Mali-G715-Immortalis MC11", "PowerVR Rogue GE8320",
                           "ANGLE (Samsung Xclipse 940) on Vulkan 1.3.279"}) {
    phone.renderer = name;
    EXPECT_TRUE(gl::find_quirks(phone).tiles) << name;
  }
  EXPECT_FALSE(api().quirks.tiles) << api().capabilities.renderer;
  EXPECT_EQ(render::default_approximation(gl::find_quirks(phone)).key_bits, 16);
  EXPECT_EQ(render::default_approximation(api().quirks), render::ApproximationSettings());
}

// GPUs blend in half floats, and every other way where those are missing or truncated.
TEST_P(WeakDevicesTest, CardsBlendInHalfFloats) {
  if (!api().capabilities.float_targets) GTEST_SKIP() << "the driver has no float targets";
  const gl::Quirks quirks = api().quirks;
  api().quirks = {.runs_on_cpu = true};
  EXPECT_EQ(render::default_accumulation(api()), render::Accumulation::single_float);
  api().quirks = {.half_float_blending_truncates = true};
  EXPECT_EQ(render::default_accumulation(api()), render::Accumulation::single_float);
  api().quirks = {};
  EXPECT_EQ(render::default_accumulation(api()), render::Accumulation::half_float);
  const bool half = std::exchange(api().capabilities.half_float_targets, false);
  EXPECT_EQ(render::default_accumulation(api()), render::Accumulation::single_float);
  api().capabilities.half_float_targets = half;
  api().quirks = quirks;
}

FLUXGS_GL_TEST_SUITE(WeakDevicesTest);

}  // namespace
}  // namespace fluxgs::test
