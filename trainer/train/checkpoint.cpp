#include "trainer/train/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "trainer/train/state_bytes.h"

namespace fluxgs {
namespace {

using nlohmann::json;

constexpr char kMagic[] = "FLUXGSCK";
constexpr std::size_t kMagicSize = 8;
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kPrefix = kMagicSize + 2 * sizeof(std::uint32_t);

/// FNV-1a, continued from `h`.
std::uint64_t hash(std::span<const std::byte> bytes, std::uint64_t h = 0xcbf29ce484222325u) {
  for (std::byte b : bytes) h = (h ^ static_cast<std::uint64_t>(b)) * 0x100000001b3u;
  return h;
}

template <class T>
void append(std::vector<std::byte>& out, const T& value) {
  const auto* p = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), p, p + sizeof(T));
}

/// The steps in the order of CompactSteps; null for none.
json rounding_header(const std::optional<RoundingState>& rounding) {
  if (!rounding) return nullptr;
  const CompactSteps& s = rounding->steps;
  return {s.position, s.log_scale, s.rotation, s.opacity, s.sh_dc, s.sh_rest, s.energy};
}

/// A whole number, which get<>() would make of any other. Throws what read_checkpoint() catches.
std::int64_t whole(const json& value) { return value.get_ref<const json::number_integer_t&>(); }

/// The nearest int: what is beyond that is out of every range here, too.
int whole_int(const json& value) {
  return static_cast<int>(std::clamp<std::int64_t>(whole(value), std::numeric_limits<int>::min(),
                                                   std::numeric_limits<int>::max()));
}

std::optional<RoundingState> read_rounding(const json& header) {
  // Checkpoints of before there was rounding have none
  const auto found = header.find("rounding");
  if (found == header.end() || found->is_null()) return {};
  const auto s = found->get<std::array<double, 7>>();
  const auto f = [&](std::size_t i) { return static_cast<float>(s[i]); };
  return RoundingState{{s[0], f(1), f(2), f(3), f(4), f(5), f(6)}, {}, {}};
}

json header_of(const Checkpoint& c) {
  std::ostringstream random;
  random << c.state.random;
  const glm::dvec3 background = c.options.render.background;
  return {{"options", options_json(c.options)},
          {"background", {background.x, background.y, background.z}},
          {"preset", c.preset},
          {"downscale", c.downscale},
          {"train_views", c.train_views},
          {"views_hash", c.views_hash},
          {"splats", c.state.parameters.size()},
          {"sh_degree", sh_degree_of(c.state.parameters)},
          {"own_degrees", !c.state.degrees.empty()},
          {"psi", c.state.networks && c.state.networks->model.psi},
          {"phi", c.state.networks && c.state.networks->model.phi},
          {"switched_at", c.state.switched_at},
          {"rounding", rounding_header(c.state.rounding)},
          {"iteration", c.state.iteration},
          {"max_pairs", c.state.max_pairs},
          {"random", random.str()},
          {"view_order", c.state.view_order},
          {"next_view", c.state.next_view},
          {"history", c.history}};
}

/// The value of a choice by its name; −1, which validate() refuses, for others.
int choice_named(const OptionField& f, const std::string& name) {
  const auto at = std::ranges::find(f.choice.names, name);
  return at == f.choice.names.end() ? -1 : static_cast<int>(at - f.choice.names.begin());
}

void read_header(const json& header, Checkpoint& c) {
  const auto& options = header.at("options").get_ref<const json::object_t&>();
  for (const OptionField& f : option_fields()) {
    // What a checkpoint of an older version does not know is as in TrainOptions
    const auto found = options.find(f.name);
    if (found == options.end()) continue;
    const json& value = found->second;
    if (f.integer) c.options.*f.integer = whole_int(value);
    if (f.real) c.options.*f.real = value.get<double>();
    if (f.natural) c.options.*f.natural = static_cast<std::uint64_t>(whole(value));
    if (f.choice.set) f.choice.set(c.options, choice_named(f, value.get<std::string>()));
  }
  for (int i = 0; i < 3; ++i)
    c.options.render.background[i] =
        header.at("background").at(static_cast<std::size_t>(i)).get<double>();
  c.preset = header.at("preset").get<std::string>();
  c.downscale = whole_int(header.at("downscale"));
  c.train_views = static_cast<std::size_t>(whole(header.at("train_views")));
  c.views_hash = static_cast<std::uint64_t>(whole(header.at("views_hash")));
  c.state.iteration = whole_int(header.at("iteration"));
  for (const json& view : header.at("view_order"))
    c.state.view_order.push_back(static_cast<std::uint32_t>(whole_int(view)));
  c.state.next_view = static_cast<std::uint32_t>(whole_int(header.at("next_view")));
  c.state.switched_at = whole_int(header.at("switched_at"));
  c.state.max_pairs = header.value("max_pairs", 0.0);
  c.state.rounding = read_rounding(header);
  c.history = header.value("history", "");
}

StateLayout read_layout(const json& header) {
  return {static_cast<std::uint64_t>(whole(header.at("splats"))),
          whole_int(header.at("sh_degree")),
          header.at("own_degrees").get<bool>(),
          header.at("psi").get<bool>(),
          header.at("phi").get<bool>(),
          read_rounding(header).has_value()};
}

/// What arrays a training with these options has. Without rounding, which may have failed.
bool fits(const StateLayout& layout, const TrainOptions& options, bool switched) {
  const bool adaptive = options.sh_target == ShTarget::adaptive;
  return layout.sh_degree == (switched ? target_degree(options) : degree_before_switch(options)) &&
         layout.own_degrees == (switched && adaptive) &&
         layout.psi == (switched && makes_psi(options)) &&
         layout.phi == (switched && makes_phi(options));
}

/// The field of a header that cannot be, and what was expected; nothing if all can.
std::optional<std::pair<const char*, std::string>> impossible(const Checkpoint& c,
                                                              const StateLayout& layout) {
  const TrainState& s = c.state;
  if (c.downscale < 1) return {{"downscale", "expected 1 or more"}};
  if (!(s.iteration >= 0 && s.iteration <= c.options.iterations))
    return {{"iteration", fmt::format("expected 0 to {}", c.options.iterations)}};
  if (!(s.switched_at >= 0 && s.switched_at <= s.iteration))
    return {{"switched_at", fmt::format("expected 0 to {}", s.iteration)}};
  if (!(s.max_pairs >= 0 && std::isfinite(s.max_pairs)))
    return {{"max_pairs", "expected 0 or more"}};
  if (!fits(layout, c.options, s.switched_at > 0))
    return {{"sh_degree", "SH coefficients or networks are not those of the options"}};
  if (s.view_order.size() != c.train_views)
    return {{"view_order", fmt::format("expected {} images", c.train_views)}};
  if (s.next_view > s.view_order.size())
    return {{"next_view", fmt::format("expected 0 to {}", s.view_order.size())}};
  for (const std::uint32_t view : s.view_order)
    if (view >= c.train_views) return {{"view_order", "names an image that is not there"}};
  return {};
}

}  // namespace

json options_json(const TrainOptions& options) {
  json out = json::object();
  for (const OptionField& f : option_fields()) {
    if (f.integer) out[f.name] = options.*f.integer;
    if (f.real) out[f.name] = options.*f.real;
    if (f.natural) out[f.name] = options.*f.natural;
    if (f.choice.get) out[f.name] = f.choice.names[static_cast<std::size_t>(f.choice.get(options))];
  }
  return out;
}

std::uint64_t hash_views(const std::vector<View>& views) {
  std::uint64_t h = hash({});
  for (const View& view : views) {
    const Camera& c = view.camera;
    double numbers[] = {
        c.fx, c.fy, c.cx, c.cy, c.translation.x, c.translation.y, c.translation.z, 0, 0, 0, 0, 0,
        0,    0,    0,    0};
    for (int i = 0; i < 9; ++i) numbers[7 + i] = c.rotation[i / 3][i % 3];
    h = hash(std::as_bytes(std::span(c.name)), h);
    h = hash(std::as_bytes(std::span(numbers)), h);
    h = hash(std::as_bytes(std::span(view.rgb.pixels)), h);
  }
  return h;
}

Expected<void> write_checkpoint(const std::filesystem::path& path, const Checkpoint& c) {
  const std::string header = header_of(c).dump();
  std::vector<std::byte> out;
  out.reserve(kPrefix + header.size() + layout_of(c.state).size().value_or(0) +
              sizeof(std::uint64_t));
  for (std::size_t i = 0; i < kMagicSize; ++i) out.push_back(static_cast<std::byte>(kMagic[i]));
  append(out, kVersion);
  append(out, static_cast<std::uint32_t>(header.size()));
  for (char ch : header) out.push_back(static_cast<std::byte>(ch));
  append_state(out, c.state);
  append(out, hash(out));
  return write_file_atomic(path, out);
}

Expected<Checkpoint> read_checkpoint(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  const auto bad = [&](const char* field, std::string what) {
    return fail(path.string(), field, std::move(what));
  };
  if (bytes->size() < kPrefix + sizeof(std::uint64_t) ||
      std::memcmp(bytes->data(), kMagic, kMagicSize) != 0)
    return bad("header", "is not a checkpoint of fluxgs train");
  std::uint32_t version, header_size;
  std::memcpy(&version, bytes->data() + kMagicSize, sizeof version);
  std::memcpy(&header_size, bytes->data() + kMagicSize + sizeof version, sizeof header_size);
  if (version != kVersion)
    return bad("version", fmt::format("is {}, expected {}", version, kVersion));
  const std::size_t body = bytes->size() - kPrefix - sizeof(std::uint64_t);
  std::uint64_t stored;
  std::memcpy(&stored, bytes->data() + bytes->size() - sizeof stored, sizeof stored);
  if (header_size > body || stored != hash({bytes->data(), bytes->size() - sizeof stored}))
    return bad("checksum", "does not match: the file is truncated or damaged");

  Checkpoint c;
  StateLayout layout;
  std::string random;
  try {
    const char* text = reinterpret_cast<const char*>(bytes->data() + kPrefix);
    const json header = json::parse(text, text + header_size);
    read_header(header, c);
    layout = read_layout(header);
    random = header.at("random").get<std::string>();
  } catch (const json::exception& e) {
    return bad("header", fmt::format("is not the expected JSON ({})", e.what()));
  }
  if (auto valid = validate(c.options); !valid) return std::unexpected(valid.error());
  if (const auto field = impossible(c, layout)) return bad(field->first, field->second);
  if (!(std::istringstream(random) >> c.state.random))
    return bad("random", "is no state of a random generator");
  if (layout.size() != body - header_size)
    return bad("splats", "their number disagrees with the size of the file");
  if (auto taken = take_state(bytes->data() + kPrefix + header_size, layout, c.state); !taken)
    return bad("networks", taken.error().what);
  return c;
}

}  // namespace fluxgs
