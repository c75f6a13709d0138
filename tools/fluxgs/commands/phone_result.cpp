#include "tools/fluxgs/commands/phone_result.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fluxgs::cli {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;  // BenchmarkResult.VERSION
constexpr int kHottest = 6;  // PowerManager.THERMAL_STATUS_SHUTDOWN

constexpr double kMaxMs = 1e7;         // hours
constexpr double kMaxPhoneSide = 1e5;  // px
constexpr double kMaxDecibels = 1000;
constexpr std::size_t kMaxRows = 10'000, kLongestText = 200;

/// Text that is safe on a terminal: what came from elsewhere might draw on it.
std::string plain(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  if (text.size() > kLongestText) text = text.substr(0, kLongestText) + "...";
  return text;
}

/// Fields by path, such as "rows/0/draw_ms/median"; the first that is wrong is remembered.
class Fields {
 public:
  explicit Fields(const json& value) : value_(value) {}

  std::string text(const std::string& path) {
    const json& v = at(path);
    return v.is_string() ? plain(v.get<std::string>()) : wrong(path, "a text", std::string());
  }
  double number(const std::string& path, double least, double most) {
    const json& v = at(path);
    const bool good = v.is_number() && v.get<double>() >= least && v.get<double>() <= most;
    return good ? v.get<double>()
                : wrong(path, fmt::format("a number from {} to {}", least, most), 0.0);
  }
  std::uint64_t count(const std::string& path) {
    const json& v = at(path);
    return v.is_number_unsigned() ? v.get<std::uint64_t>()
                                  : wrong(path, "a count", std::uint64_t{0});
  }
  std::size_t size(const std::string& path) {
    const json& v = at(path);
    return v.is_array() ? v.size() : wrong(path, "a list", std::size_t{0});
  }
  const json& at(const std::string& path) const {
    static const json kMissing;
    const json::json_pointer pointer("/" + path);
    return value_.contains(pointer) ? value_[pointer] : kMissing;
  }

  const std::string& place() const { return place_; }
  const std::string& expected() const { return expected_; }

 private:
  template <class T>
  T wrong(const std::string& path, const std::string& expected, T nothing) {
    if (place_.empty()) place_ = path, expected_ = expected;
    return nothing;
  }

  const json& value_;
  std::string place_, expected_;
};

PhoneRow row_of(Fields& f, std::size_t i) {
  constexpr double kShortest = 1e-6;  // ms
  const std::string at = fmt::format("rows/{}/", i);
  PhoneRow row;
  row.width = static_cast<int>(f.number(at + "width", 1, kMaxPhoneSide));
  row.height = static_cast<int>(f.number(at + "height", 1, kMaxPhoneSide));
  row.views = f.text(at + "views");
  row.sorter = f.text(at + "sorter");
  row.draw_ms = f.number(at + "draw_ms/median", kShortest, kMaxMs);
  row.in_flight_ms = f.at(at + "in_flight_ms").is_null()
                         ? row.draw_ms
                         : f.number(at + "in_flight_ms/median", kShortest, kMaxMs);
  row.sort_to_display_ms = f.number(at + "sort_to_display_ms/median", kShortest, kMaxMs);
  row.pipelined_ms = f.number(at + "pipelined_ms", kShortest, kMaxMs);
  return row;
}

/// A list of texts, as one.
std::string joined(Fields& f, const std::string& path) {
  std::string all;
  for (std::size_t i = 0; i < std::min(f.size(path), kMaxRows); ++i)
    all += (i == 0 ? "" : ", ") + f.text(fmt::format("{}/{}", path, i));
  return all;
}

/// bench::to_json() of a DriverCheck in words; apps of before have none.
std::string driver_check_of(Fields& f) {
  if (!f.at("driver_check").is_object()) return {};
  if (f.at("driver_check/right") != true)
    return "DRAWS WRONG PICTURES: " + joined(f, "driver_check/faults");
  const std::string limits = joined(f, "driver_check/limits");
  return fmt::format("draws the sample right, {:.1f} dB{}{}",
                     f.number("driver_check/psnr", 0, kMaxDecibels), limits.empty() ? "" : " with ",
                     limits);
}

}  // namespace

std::string PhoneRow::name() const {
  return fmt::format("{}x{} {} {}", width, height, views, sorter);
}

Expected<PhoneResult> phone_result(const json& value, const std::string& file) {
  Fields f(value);
  if (f.count("version") != kVersion)
    return fail(file, "version", fmt::format("expected {}, of the app's benchmark", kVersion));
  PhoneResult r;
  const std::string maker = f.text("device/manufacturer"), model = f.text("device/model"),
                    soc = f.text("device/soc"), android = f.text("device/android");
  r.device = fmt::format("{} {} ({}), Android {}", maker, model, soc, android);
  r.driver = f.at("driver").is_null()
                 ? "no driver"
                 : fmt::format("{}, {}", f.text("driver/renderer"), f.text("driver/version"));
  r.driver_check = driver_check_of(f);
  r.app = f.text("app/name");
  r.scene = f.text("scene/name");
  r.splats = f.count("scene/splats");
  r.bytes = f.count("scene/bytes");
  r.warmup = f.count("protocol/warmup");
  r.frames = f.count("protocol/frames");
  if (f.at("rows/0/blended_in").is_string()) r.blended_in = f.text("rows/0/blended_in");
  r.beside_another = f.at("multi_window") == true;
  r.heat_before = static_cast<int>(f.number("thermal/before/status", -1, kHottest));
  r.heat_after = static_cast<int>(f.number("thermal/after/status", -1, kHottest));
  r.stopped = f.text("stopped");
  for (const char* name : {"splats", "decoded", "sorted", "projected", "error"})
    if (const json& v = f.at(std::string("self_test/") + name); v.is_primitive() && !v.is_null())
      r.self_test[name] = plain(v.is_string() ? v.get<std::string>() : v.dump());
  const std::size_t rows = std::min(f.size("rows"), kMaxRows);
  for (std::size_t i = 0; i < rows && f.place().empty(); ++i) r.rows.push_back(row_of(f, i));
  if (!f.place().empty()) return fail(file, f.place(), "expected " + f.expected());
  return r;
}

}  // namespace fluxgs::cli
