// The functions of org.fluxgs.app.Native: a thin layer over viewer::Session. No exception of C++
// crosses into Java: it becomes a RuntimeException. A session that is not there is an
// IllegalStateException, arrays of the wrong length an IllegalArgumentException.
#include <jni.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/self_test.h"
#include "platform/android/platform.h"
#include "viewer/decode_memory_guard.h"
#include "viewer/screen_check.h"
#include "viewer/session.h"
#include "viewer/session_json.h"

namespace fluxgs::android {
namespace {

using viewer::Session;

/// The sessions by the numbers that Java knows them by. A number is never used twice, so that one
/// that is gone is noticed.
class Sessions {
 public:
  jlong add(std::shared_ptr<Session> session) {
    const std::lock_guard lock(mutex_);
    sessions_.emplace(++last_, std::move(session));
    return last_;
  }
  std::shared_ptr<Session> find(jlong handle) {
    const std::lock_guard lock(mutex_);
    const auto found = sessions_.find(handle);
    if (found == sessions_.end()) throw std::logic_error("there is no such session");
    return found->second;
  }
  void remove(jlong handle) {
    std::shared_ptr<Session> gone = find(handle);  // ends outside of the lock
    const std::lock_guard lock(mutex_);
    sessions_.erase(handle);
  }

 private:
  std::mutex mutex_;
  std::map<jlong, std::shared_ptr<Session>> sessions_;
  jlong last_ = 0;
};

Sessions& sessions() {
  static Sessions all;
  return all;
}

void throw_java(JNIEnv* env, const char* name, const char* message) {
  if (env->ExceptionCheck()) return;
  if (jclass type = env->FindClass(name)) env->ThrowNew(type, message);
}

/// Runs `work`; what it throws becomes Java's.
template <class Work>
auto guarded(JNIEnv* env, Work&& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::invalid_argument& problem) {
    throw_java(env, "java/lang/IllegalArgumentException", problem.what());
  } catch (const std::logic_error& problem) {
    throw_java(env, "java/lang/IllegalStateException", problem.what());
  } catch (const std::exception& problem) {
    throw_java(env, "java/lang/RuntimeException", problem.what());
  } catch (...) {
    throw_java(env, "java/lang/RuntimeException", "unknown failure");
  }
  return decltype(work())();
}

/// Java has modified UTF-8, and only of what it was given; other bytes must not reach it.
jstring to_java(JNIEnv* env, const std::string& text) {
  std::vector<jchar> units;
  units.reserve(text.size());
  // nlohmann::json has made it valid UTF-8
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t at) -> std::uint32_t {
      return at < text.size() ? static_cast<unsigned char>(text[at]) : 0x80U;
    };
    std::uint32_t code = byte(i);
    const std::size_t length = code < 0x80 ? 1 : code < 0xE0 ? 2 : code < 0xF0 ? 3 : 4;
    if (length > 1) code &= 0x7FU >> length;
    for (std::size_t k = 1; k < length; ++k) code = code << 6 | (byte(i + k) & 0x3FU);
    i += length;
    if (code < 0x10000) {
      units.push_back(static_cast<jchar>(code));
    } else {
      units.push_back(static_cast<jchar>(0xD800 + ((code - 0x10000) >> 10)));
      units.push_back(static_cast<jchar>(0xDC00 + ((code - 0x10000) & 0x3FF)));
    }
  }
  return env->NewString(units.data(), static_cast<jsize>(units.size()));
}

void append_utf8(std::string& text, std::uint32_t code) {
  const auto put = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  const auto more = [&](int shift) { put(0x80U | (code >> shift & 0x3FU)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xC0U | code >> 6), more(0);
  } else if (code < 0x10000) {
    put(0xE0U | code >> 12), more(6), more(0);
  } else {
    put(0xF0U | code >> 18), more(12), more(6), more(0);
  }
}

/// GetStringUTFChars() would give Java's own UTF-8, which has other bytes for 0 and beyond U+FFFF.
std::string from_java(JNIEnv* env, jstring text) {
  if (text == nullptr) return {};
  std::u16string units(static_cast<std::size_t>(env->GetStringLength(text)), u'\0');
  env->GetStringRegion(text, 0, static_cast<jsize>(units.size()),
                       reinterpret_cast<jchar*>(units.data()));
  std::string result;
  for (std::size_t i = 0; i < units.size(); ++i) {
    std::uint32_t code = units[i];
    const bool high = code >= 0xD800 && code < 0xDC00;
    if (high && i + 1 < units.size() && units[i + 1] >= 0xDC00 && units[i + 1] < 0xE000)
      code = 0x10000 + ((code - 0xD800) << 10) + (units[++i] - 0xDC00U);
    else if (code >= 0xD800 && code < 0xE000)
      code = 0xFFFD;  // half of a pair
    append_utf8(result, code);
  }
  return result;
}

std::vector<jdouble> numbers(JNIEnv* env, jdoubleArray array) {
  std::vector<jdouble> values(static_cast<std::size_t>(env->GetArrayLength(array)));
  env->GetDoubleArrayRegion(array, 0, static_cast<jsize>(values.size()), values.data());
  return values;
}
std::vector<jint> numbers(JNIEnv* env, jintArray array) {
  std::vector<jint> values(static_cast<std::size_t>(env->GetArrayLength(array)));
  env->GetIntArrayRegion(array, 0, static_cast<jsize>(values.size()), values.data());
  return values;
}
std::vector<jfloat> numbers(JNIEnv* env, jfloatArray array) {
  std::vector<jfloat> values(static_cast<std::size_t>(env->GetArrayLength(array)));
  env->GetFloatArrayRegion(array, 0, static_cast<jsize>(values.size()), values.data());
  return values;
}

std::vector<std::byte> bytes_of(JNIEnv* env, jbyteArray array) {
  std::vector<std::byte> values(static_cast<std::size_t>(env->GetArrayLength(array)));
  env->GetByteArrayRegion(array, 0, static_cast<jsize>(values.size()),
                          reinterpret_cast<jbyte*>(values.data()));
  return values;
}

void expect(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

/// Java keeps a saved view as 12 values: target, orientation (w, x, y, z), distance, field of view,
/// up.
constexpr std::size_t kViewValues = 12;
constexpr const char* kViewHas = "a saved view has 12 values";

viewer::SavedView saved_view_of(const jdouble* v) {
  return {.view = {.target = {v[0], v[1], v[2]},
                   .orientation = {v[3], v[4], v[5], v[6]},
                   .distance = v[7],
                   .fov = v[8]},
          .up = {v[9], v[10], v[11]}};
}

std::optional<viewer::SavedView> saved_view_from(JNIEnv* env, jdoubleArray array) {
  if (array == nullptr) return std::nullopt;
  const std::vector<jdouble> v = numbers(env, array);
  expect(v.size() == kViewValues, kViewHas);
  return saved_view_of(v.data());
}

/// One after the other; those that are no views are left out.
std::vector<camera::ViewState> views_from(JNIEnv* env, jdoubleArray array) {
  const std::vector<jdouble> v = numbers(env, array);
  expect(v.size() % kViewValues == 0, kViewHas);
  std::vector<camera::ViewState> views;
  for (std::size_t i = 0; i < v.size(); i += kViewValues)
    if (const auto sound = viewer::restored(saved_view_of(&v[i]))) views.push_back(sound->view);
  expect(!views.empty(), "a path goes through one view at least");
  return views;
}

std::array<jdouble, 12> values_of(const viewer::SavedView& saved) {
  const auto& [target, turn, distance, fov] = saved.view;
  const glm::dvec3& up = saved.up;
  return {target.x, target.y, target.z, turn.w, turn.x, turn.y,
          turn.z,   distance, fov,      up.x,   up.y,   up.z};
}

constexpr double kMillisecond = 1e-3, kNanosecond = 1e-9;

}  // namespace
}  // namespace fluxgs::android

using namespace fluxgs;           // NOLINT(google-build-using-namespace)
using namespace fluxgs::android;  // NOLINT(google-build-using-namespace)

#define FLUXGS_JNI(type, name) extern "C" JNIEXPORT type JNICALL Java_org_fluxgs_app_Native_##name

FLUXGS_JNI(jlong, create)(JNIEnv* env, jclass) {
  return guarded(env, [] { return sessions().add(std::make_shared<Session>(make_screen())); });
}

FLUXGS_JNI(void, destroy)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().remove(session); });
}

FLUXGS_JNI(void, surfaceCreated)(JNIEnv* env, jclass, jlong session, jobject surface) {
  guarded(env, [&] {
    const auto found = sessions().find(session);
    if (void* window = window_of(env, surface)) found->surface_created(window);
  });
}

FLUXGS_JNI(void, surfaceChanged)(JNIEnv* env, jclass, jlong session, jint width, jint height,
                                 jfloat density) {
  guarded(env, [&] { sessions().find(session)->surface_changed(width, height, density); });
}

FLUXGS_JNI(void, surfaceDestroyed)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->surface_destroyed(); });
}

FLUXGS_JNI(jlong, load)
(JNIEnv* env, jclass, jlong session, jint descriptor, jstring name, jlong bytes, jlong memory,
 jdoubleArray place) {
  return guarded(env, [&] {
    try {
      viewer::LoadLimits limits;
      limits.memory = static_cast<std::uint64_t>(std::max<jlong>(memory, 0));
      if (bytes >= 0) limits.announced = static_cast<std::uint64_t>(bytes);
      const auto found = sessions().find(session);
      const auto from = saved_view_from(env, place);
      return static_cast<jlong>(found->load(descriptor, from_java(env, name), limits, from));
    } catch (...) {
      ::close(descriptor);  // it was passed on
      throw;
    }
  });
}

FLUXGS_JNI(void, cancelLoading)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->cancel_loading(); });
}

FLUXGS_JNI(jboolean, frame)(JNIEnv* env, jclass, jlong session, jlong nanoseconds) {
  return guarded(env, [&] {
    const double seconds = kNanosecond * static_cast<double>(nanoseconds);
    return static_cast<jboolean>(sessions().find(session)->frame(seconds) ? JNI_TRUE : JNI_FALSE);
  });
}

FLUXGS_JNI(jint, drawingThread)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&] { return jint{sessions().find(session)->drawing_thread()}; });
}

FLUXGS_JNI(jlong, frameWork)(JNIEnv* env, jclass, jlong session) {
  return guarded(
      env, [&] { return static_cast<jlong>(sessions().find(session)->frame_work().count()); });
}

FLUXGS_JNI(void, drawNow)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->draw_now(); });
}

FLUXGS_JNI(void, touch)
(JNIEnv* env, jclass, jlong session, jint phase, jint changed, jintArray ids, jfloatArray positions,
 jlong milliseconds) {
  guarded(env, [&] {
    const std::vector<jint> names = numbers(env, ids);
    const std::vector<jfloat> at = numbers(env, positions);
    expect(at.size() == 2 * names.size(), "there are two coordinates for each finger");
    expect(phase >= 0 && phase <= 3, "a phase is 0 to 3");
    std::vector<viewer::Finger> fingers;
    for (std::size_t i = 0; i < names.size(); ++i)
      fingers.push_back({names[i], {at[2 * i], at[2 * i + 1]}});
    sessions().find(session)->touch(static_cast<viewer::TouchPhase>(phase), changed,
                                    std::move(fingers),
                                    kMillisecond * static_cast<double>(milliseconds));
  });
}

FLUXGS_JNI(void, turn)
(JNIEnv* env, jclass, jlong session, jfloat x, jfloat y, jfloat z, jfloat w, jint screen_turns,
 jlong nanoseconds) {
  guarded(env, [&] {
    const auto d = [](jfloat v) { return static_cast<double>(v); };
    sessions().find(session)->turn({.rotation = {d(w), d(x), d(y), d(z)},
                                    .screen_turns = screen_turns,
                                    .seconds = kNanosecond * static_cast<double>(nanoseconds)});
  });
}

FLUXGS_JNI(void, set)
(JNIEnv* env, jclass, jlong session, jfloat scale, jfloat moving_scale, jint sorter, jint sh_degree,
 jint max_splats, jboolean gyroscope, jboolean measures, jfloat frame_seconds, jlong memory,
 jint background) {
  guarded(env, [&] {
    expect(sorter >= 0 && sorter <= 2, "a sorter is 0 to 2");
    expect(scale == 0 || (scale >= 0.2F && scale <= 1), "a scale is 0 or 0.2 to 1");
    expect(moving_scale >= 0.2F && moving_scale <= 1, "a scale while moving is 0.2 to 1");
    viewer::ViewerSettings settings;
    settings.scale = static_cast<double>(scale);
    settings.moving_scale = static_cast<double>(moving_scale);
    settings.sorter = static_cast<viewer::SorterChoice>(sorter);
    settings.sh_degree = std::clamp<int>(sh_degree, 0, 3);
    settings.max_splats = static_cast<std::size_t>(std::max<jint>(max_splats, 0));
    settings.gyroscope = gyroscope == JNI_TRUE;
    settings.measures = measures == JNI_TRUE;
    settings.frame_seconds = static_cast<double>(frame_seconds);
    const auto channel = [&](int shift) { return (background >> shift & 0xFF) / 255.0; };
    settings.background = {channel(16), channel(8), channel(0)};
    if (memory > 0) settings.memory = static_cast<std::size_t>(memory);
    sessions().find(session)->set(settings);
  });
}

FLUXGS_JNI(void, setHeat)(JNIEnv* env, jclass, jlong session, jint status, jfloat headroom) {
  guarded(env,
          [&] { sessions().find(session)->set_heat({status, static_cast<double>(headroom)}); });
}

FLUXGS_JNI(void, setDriverLimits)(JNIEnv* env, jclass, jlong session, jstring names) {
  guarded(env, [&] {
    sessions().find(session)->set_driver_limits(render::limits_named(from_java(env, names)));
  });
}

FLUXGS_JNI(jstring, checkDriver)
(JNIEnv* env, jclass, jbyteArray scene, jbyteArray golden, jstring known) {
  return guarded(env, [&] {
    const auto screen = make_screen();
    const auto checked = viewer::check_driver_of(*screen, bytes_of(env, scene),
                                                 bytes_of(env, golden), from_java(env, known));
    if (!checked) throw std::runtime_error(checked.error().message());
    return to_java(env, *checked);
  });
}

FLUXGS_JNI(void, flipUp)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->flip_up(); });
}

FLUXGS_JNI(void, goTo)(JNIEnv* env, jclass, jlong session, jdoubleArray place) {
  guarded(env, [&] {
    if (const auto saved = saved_view_from(env, place)) sessions().find(session)->go_to(*saved);
  });
}

FLUXGS_JNI(void, resetView)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->reset_view(); });
}

FLUXGS_JNI(void, drift)(JNIEnv* env, jclass, jlong session, jboolean on) {
  guarded(env, [&] { sessions().find(session)->drift(on == JNI_TRUE); });
}

FLUXGS_JNI(jdouble, pathThrough)
(JNIEnv* env, jclass, jlong session, jdoubleArray places, jboolean closed, jdouble seconds) {
  return guarded(env, [&] {
    const auto views = views_from(env, places);
    return sessions().find(session)->set_path(
        camera::path_through(views, closed == JNI_TRUE, seconds));
  });
}

FLUXGS_JNI(jdouble, pathAround)(JNIEnv* env, jclass, jlong session, jdouble seconds) {
  return guarded(env, [&] {
    const auto found = sessions().find(session);
    const auto saved = found->saved_view();
    if (!saved) throw std::logic_error("there is no scene");
    return found->set_path(camera::orbit_path(saved->view, saved->up, seconds));
  });
}

FLUXGS_JNI(jdouble, pathOf)(JNIEnv* env, jclass, jlong session, jbyteArray json) {
  return guarded(env, [&] {
    const auto track = read_supersplat_track(bytes_of(env, json), "");
    if (!track) throw std::invalid_argument(track.error().message());
    return sessions().find(session)->set_path(camera::path_of(*track));
  });
}

FLUXGS_JNI(void, play)(JNIEnv* env, jclass, jlong session, jboolean on) {
  guarded(env, [&] { sessions().find(session)->play(on == JNI_TRUE); });
}

// Starts a video; `surface` is the window of its encoder.
FLUXGS_JNI(void, startVideo)
(JNIEnv* env, jclass, jlong session, jobject surface, jint width, jint height, jdouble fps) {
  guarded(env, [&] {
    constexpr jint kMostPixels = 8192;
    expect(width >= 1 && height >= 1 && width <= kMostPixels && height <= kMostPixels,
           "the sides of a video are 1 to 8192");
    expect(fps >= 1 && fps <= 240, "a video has 1 to 240 frames a second");
    const auto found = sessions().find(session);
    if (found->video().running) throw std::logic_error("a video is being made");
    void* const window = window_of(env, surface);
    expect(window != nullptr, "the encoder has no surface");
    found->start_video(window, {.width = width, .height = height, .fps = fps});
  });
}

FLUXGS_JNI(void, stopVideo)(JNIEnv* env, jclass, jlong session, jstring why) {
  guarded(env, [&] { sessions().find(session)->stop_video(from_java(env, why)); });
}

FLUXGS_JNI(jstring, video)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&] { return to_java(env, to_json(sessions().find(session)->video())); });
}

FLUXGS_JNI(void, walk)(JNIEnv* env, jclass, jlong session, jboolean on) {
  guarded(env, [&] { sessions().find(session)->walk(on == JNI_TRUE); });
}

FLUXGS_JNI(void, stick)(JNIEnv* env, jclass, jlong session, jfloat right, jfloat ahead) {
  guarded(env, [&] {
    sessions().find(session)->stick(static_cast<double>(right), static_cast<double>(ahead));
  });
}

// Kinds are those of viewer::WindowEvent, buttons those of viewer::PointerButton.
FLUXGS_JNI(void, windowEvent)
(JNIEnv* env, jclass, jlong session, jint kind, jfloat x, jfloat y, jint button, jboolean down,
 jfloat amount, jint key, jlong milliseconds) {
  guarded(env, [&] {
    using viewer::WindowEvent;
    expect(kind >= 0 && kind <= static_cast<jint>(WindowEvent::Kind::focus_lost),
           "kinds are 0 to 5");
    expect(button >= 0 && button <= 2, "buttons are 0 to 2");
    expect(key >= 0 && key < 128, "keys are ASCII characters");
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(amount)) return;
    sessions().find(session)->handle({.kind = static_cast<WindowEvent::Kind>(kind),
                                      .position = {static_cast<double>(x), static_cast<double>(y)},
                                      .button = static_cast<viewer::PointerButton>(button),
                                      .down = down == JNI_TRUE,
                                      .amount = static_cast<double>(amount),
                                      .key = static_cast<char>(key)},
                                     kMillisecond * static_cast<double>(milliseconds));
  });
}

FLUXGS_JNI(void, freeGraphics)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->free_graphics(); });
}

FLUXGS_JNI(void, loseContext)(JNIEnv* env, jclass, jlong session) {
  guarded(env, [&] { sessions().find(session)->lose_context(); });
}

FLUXGS_JNI(jstring, state)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&] { return to_java(env, to_json(sessions().find(session)->state())); });
}

FLUXGS_JNI(jdoubleArray, place)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&]() -> jdoubleArray {
    const auto saved = sessions().find(session)->saved_view();
    if (!saved) return nullptr;
    const auto values = values_of(*saved);
    const auto count = static_cast<jsize>(values.size());
    jdoubleArray result = env->NewDoubleArray(count);
    if (result != nullptr) env->SetDoubleArrayRegion(result, 0, count, values.data());
    return result;
  });
}

// Width, height, then a colour a pixel as Bitmap.setPixels() takes them.
FLUXGS_JNI(jintArray, image)(JNIEnv* env, jclass, jlong session, jint longest, jlong of) {
  return guarded(env, [&]() -> jintArray {
    const auto image =
        sessions().find(session)->image(std::max<jint>(longest, 0), static_cast<std::uint64_t>(of));
    if (!image) return nullptr;
    const jint size[] = {image->width, image->height};
    jintArray result = env->NewIntArray(2 + size[0] * size[1]);
    if (result == nullptr) return nullptr;
    env->SetIntArrayRegion(result, 0, 2, size);
    std::vector<jint> row(static_cast<std::size_t>(size[0]));
    for (int y = 0; y < size[1]; ++y) {
      for (int x = 0; x < size[0]; ++x) {
        const auto pixel = image->at(x, y);
        row[static_cast<std::size_t>(x)] =
            static_cast<jint>(0xFF000000U | std::uint32_t{pixel[0]} << 16 |
                              std::uint32_t{pixel[1]} << 8 | std::uint32_t{pixel[2]});
      }
      env->SetIntArrayRegion(result, 2 + y * size[0], size[0], row.data());
    }
    return result;
  });
}

FLUXGS_JNI(jstring, driver)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&] { return to_java(env, sessions().find(session)->driver()); });
}

FLUXGS_JNI(void, startBenchmark)
(JNIEnv* env, jclass, jlong session, jintArray sizes, jint warmup, jint frames, jboolean gpu_sort,
 jboolean cpu_sort, jint slices) {
  guarded(env, [&] {
    const std::vector<jint> sides = numbers(env, sizes);
    expect(!sides.empty() && sides.size() % 2 == 0, "sizes are pairs of width and height");
    expect(warmup >= 0 && frames >= 1 && frames <= 100'000, "frames are 1 to 100000");
    expect(slices >= 1 && slices <= render::kMostSlices, "slices are 1 to 64");
    bench::SceneBenchmarkPlan plan;
    plan.sizes.clear();
    for (std::size_t i = 0; i < sides.size(); i += 2) {
      expect(sides[i] >= 1 && sides[i + 1] >= 1, "sizes are at least 1");
      plan.sizes.push_back({sides[i], sides[i + 1]});
    }
    plan.protocol = {.warmup = warmup, .frames = frames};
    plan.gpu_sort = gpu_sort == JNI_TRUE;
    plan.cpu_sort = cpu_sort == JNI_TRUE;
    plan.slices = slices;
    sessions().find(session)->start_benchmark(plan);
  });
}

FLUXGS_JNI(void, stopBenchmark)(JNIEnv* env, jclass, jlong session, jstring why) {
  guarded(env, [&] { sessions().find(session)->stop_benchmark(from_java(env, why)); });
}

FLUXGS_JNI(jstring, benchmark)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&] { return to_java(env, to_json(sessions().find(session)->benchmark())); });
}

FLUXGS_JNI(jstring, selfTest)(JNIEnv* env, jclass, jlong session) {
  return guarded(env, [&] {
    const viewer::DecodeMemoryGuard guard;  // the session may end meanwhile
    const auto scene = sessions().find(session)->scene();
    if (!scene) throw std::logic_error("there is no scene");
    return to_java(env, bench::to_json(bench::self_test(*scene)));
  });
}

FLUXGS_JNI(void, waitForHeldScenes)(JNIEnv* env, jclass) {
  guarded(env, [] { viewer::DecodeMemoryGuard::wait_for_none(); });
}

FLUXGS_JNI(jstring, about)(JNIEnv* env, jclass) {
  return guarded(env, [&] {
    return to_java(env, nlohmann::json{{"version", FLUXGS_VERSION},
                                       {"platform", kPlatform},
                                       {"build", FLUXGS_APP_BUILD},
                                       // tools/apk looks for this text in the library
                                       {"library", "fluxgs " FLUXGS_APP_BUILD " build"}}
                            .dump());
  });
}
