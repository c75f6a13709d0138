#include "trainer/train/checkpoint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/hash.h"
#include "fluxgs/io/file.h"
#include "trainer/data/photo_memory.h"
#include "trainer/train/schedule.h"
#include "trainer/train/state_bytes.h"

namespace fluxgs {
namespace {

using nlohmann::json;

constexpr char kMagic[] = "FLUXGSCK";
constexpr std::size_t kMagicSize = 8;
constexpr std::uint32_t kVersion = 4;
constexpr std::size_t kPrefix = kMagicSize + 2 * sizeof(std::uint32_t);

template <class T>
void append(std::vector<std::byte>& out, const T& value) {
  const auto* p = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), p, p + sizeof(T));
}

/// A whole number, which get<>() would make of any other. Throws what read_checkpoint() catches.
std::int64_t whole(const json& value) { return value.get_ref<const json::number_integer_t&>(); }

/// The nearest int: what is beyond that is out of every range here, too.
int whole_int(const json& value) {
  return static_cast<int>(std::clamp<std::int64_t>(whole(value), std::numeric_limits<int>::min(),
                                                   std::numeric_limits<int>::max()));
}

json start_json(const std::optional<InitialView>& start) {
  if (!start) return nullptr;
  const glm::dvec3 &at = start->position, &up = start->up;
  const glm::dquat& q = start->orientation;
  return {{"position", {at.x, at.y, at.z}},
          {"orientation", {q.w, q.x, q.y, q.z}},
          {"fov_y", start->fov_y},
          {"up", {up.x, up.y, up.z}},
          {"image_size", {start->image_width, start->image_height}}};
}

/// Nothing of numbers that no view has.
std::optional<InitialView> read_start(const json& start) {
  if (start.is_null()) return {};
  const auto p = start.at("position").get<std::array<double, 3>>();
  const auto q = start.at("orientation").get<std::array<double, 4>>();
  const auto up = start.at("up").get<std::array<double, 3>>();
  const auto size = start.at("image_size").get<std::array<int, 2>>();
  const InitialView view{.position = {p[0], p[1], p[2]},
                         .orientation = {q[0], q[1], q[2], q[3]},
                         .fov_y = start.at("fov_y").get<double>(),
                         .up = {up[0], up[1], up[2]},
                         .image_width = size[0],
                         .image_height = size[1]};
  return is_sound(view) ? std::optional(view) : std::nullopt;
}

json header_of(const Checkpoint& c) {
  std::ostringstream random;
  random << c.state.random;
  const glm::dvec3 background = c.options.render.background;
  const StateLayout layout = layout_of(c.state);
  json attached = json::array(), phase_values = json::array();
  for (const auto& a : layout.attached) attached.push_back({a.name, a.rows, a.moments});
  for (const auto& v : layout.phase_values) phase_values.push_back({v.name, v.count});
  return {{"options", options_json(c.options)},
          {"compact_output", c.options.compact_output},
          {"background", {background.x, background.y, background.z}},
          {"preset", c.preset},
          {"downscale", c.downscale},
          {"train_views", c.train_views},
          {"views_hash", c.views_hash},
          {"splats", layout.splats},
          {"sh_degree", layout.sh_degree},
          {"own_degrees", layout.own_degrees},
          {"attached", attached},
          {"phase_values", phase_values},
          {"iteration", c.state.iteration},
          {"max_pairs", c.state.max_pairs},
          {"splat_worth", c.state.splat_worth},
          {"random", random.str()},
          {"view_order", c.state.view_order},
          {"next_view", c.state.next_view},
          {"history", c.history},
          {"start", start_json(c.start)}};
}

/// The value of an option from its text or number; what is out of range is refused later.
void read_option(OptionField& f, const json& value) {
  if (auto** p = std::get_if<int*>(&f.value)) **p = whole_int(value);
  if (auto** p = std::get_if<double*>(&f.value)) **p = value.get<double>();
  if (auto** p = std::get_if<std::uint64_t*>(&f.value))
    **p = static_cast<std::uint64_t>(whole(value));
  if (auto** p = std::get_if<bool*>(&f.value)) **p = value.get<bool>();
  if (auto* choice = std::get_if<OptionChoice>(&f.value)) {
    const auto at = std::ranges::find(choice->names, value.get<std::string>());
    choice->set(static_cast<int>(at - choice->names.begin()));
  }
}

void read_header(const json& header, Checkpoint& c) {
  c.options = default_options();
  const auto& options = header.at("options").get_ref<const json::object_t&>();
  for (OptionField& f : c.options.fields())
    if (const auto found = options.find(f.name); found != options.end())
      read_option(f, found->second);
  c.options.compact_output = header.at("compact_output").get<bool>();
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
  c.state.max_pairs = header.at("max_pairs").get<double>();
  c.state.splat_worth = header.at("splat_worth").get<double>();
  c.history = header.at("history").get<std::string>();
  if (const auto start = header.find("start"); start != header.end()) c.start = read_start(*start);
}

StateLayout read_layout(const json& header) {
  StateLayout layout{.splats = static_cast<std::uint64_t>(whole(header.at("splats"))),
                     .sh_degree = whole_int(header.at("sh_degree")),
                     .own_degrees = header.at("own_degrees").get<bool>()};
  for (const json& a : header.at("attached").get_ref<const json::array_t&>())
    layout.attached.push_back(
        {a.at(0).get<std::string>(), whole_int(a.at(1)), a.at(2).get<bool>()});
  for (const json& v : header.at("phase_values").get_ref<const json::array_t&>())
    layout.phase_values.push_back(
        {v.at(0).get<std::string>(), static_cast<std::uint64_t>(whole(v.at(1)))});
  return layout;
}

/// The field of a header that cannot be, and what was expected; nothing if all can.
std::optional<std::pair<const char*, std::string>> impossible(const Checkpoint& c,
                                                              const StateLayout& layout) {
  const TrainState& s = c.state;
  if (c.downscale < 0) return {{"downscale", "expected 0 or more"}};
  if (!(s.iteration >= 0 && s.iteration <= c.options.iterations))
    return {{"iteration", fmt::format("expected 0 to {}", c.options.iterations)}};
  if (!(s.max_pairs >= 0 && std::isfinite(s.max_pairs)))
    return {{"max_pairs", "expected 0 or more"}};
  if (layout.sh_degree != initial_sh_degree(c.options) &&
      layout.sh_degree != final_sh_degree(c.options))
    return {{"sh_degree", "the SH degrees are not those of the options"}};
  if (s.view_order.size() != c.train_views)
    return {{"view_order", fmt::format("expected {} images", c.train_views)}};
  if (s.next_view > s.view_order.size())
    return {{"next_view", fmt::format("expected 0 to {}", s.view_order.size())}};
  for (const std::uint32_t view : s.view_order)
    if (view >= c.train_views) return {{"view_order", "names an image that is not there"}};
  return {};
}

/// True if every phase can go on from its values.
Expected<void> check_phases(const TrainState& state, const TrainOptions& options) {
  const Schedule schedule = plan_schedule(options);
  for (const auto& phase : schedule.phases) {
    const auto values = state.phase_values.find(phase->name());
    if (auto ok = phase->load(
            values == state.phase_values.end() ? std::vector<double>() : values->second, state);
        !ok)
      return ok;
  }
  return {};
}

}  // namespace

json options_json(const TrainOptions& options) {
  TrainOptions copy = options;  // fields are bound to objects that may change
  json out = json::object();
  for (const OptionField& f : copy.fields()) {
    if (auto* const* p = std::get_if<int*>(&f.value)) out[f.name] = **p;
    if (auto* const* p = std::get_if<double*>(&f.value)) out[f.name] = **p;
    if (auto* const* p = std::get_if<std::uint64_t*>(&f.value)) out[f.name] = **p;
    if (auto* const* p = std::get_if<bool*>(&f.value)) out[f.name] = **p;
    if (std::holds_alternative<OptionChoice>(f.value)) out[f.name] = text_of(f);
  }
  return out;
}

std::uint64_t hash_views(const std::vector<View>& views) {
  std::uint64_t h = kFnv1aOffset;
  for (const View& view : views) {
    const Camera& c = view.camera;
    double values[] = {
        c.fx, c.fy, c.cx, c.cy, c.translation.x, c.translation.y, c.translation.z, 0, 0, 0, 0, 0,
        0,    0,    0,    0};
    for (int i = 0; i < 9; ++i) values[7 + i] = c.rotation[i / 3][i % 3];
    h = fnv1a(std::as_bytes(std::span(c.name)), h);
    h = fnv1a(std::as_bytes(std::span(values)), h);
    for (const auto* layer : {&view.rgb, &view.used, &view.alpha})
      h = fnv1a(std::as_bytes(std::span(layer->pixels)), h);
    let_go(view);
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
  append(out, fnv1a(out));
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
    return bad("version", fmt::format("{} was written by another version of fluxgs; this one reads "
                                      "{}, start the training anew",
                                      version, kVersion));
  const std::size_t body = bytes->size() - kPrefix - sizeof(std::uint64_t);
  std::uint64_t stored;
  std::memcpy(&stored, bytes->data() + bytes->size() - sizeof stored, sizeof stored);
  if (header_size > body || stored != fnv1a({bytes->data(), bytes->size() - sizeof stored}))
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
  if (auto valid = c.options.validate(); !valid) return std::unexpected(valid.error());
  if (const auto field = impossible(c, layout)) return bad(field->first, field->second);
  if (!(std::istringstream(random) >> c.state.random))
    return bad("random", "is no state of a random generator");
  if (layout.size() != body - header_size)
    return bad("splats", "their number disagrees with the size of the file");
  take_state(bytes->data() + kPrefix + header_size, layout, c.state);
  if (auto ok = check_phases(c.state, c.options); !ok)
    return bad(ok.error().field.c_str(), ok.error().what);
  return c;
}

bool is_checkpoint(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  char begin[kMagicSize] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof begin);
  return std::memcmp(begin, kMagic, kMagicSize) == 0;
}

SplatCloud scene_of(const Checkpoint& checkpoint) {
  const TrainState& state = checkpoint.state;
  PlanarFloats parameters = state.parameters;
  const Schedule schedule = plan_schedule(checkpoint.options);
  for (const auto& phase : schedule.phases) {
    // What a checkpoint holds was checked when it was read
    if (const auto values = state.phase_values.find(phase->name());
        values != state.phase_values.end())
      (void)phase->load(values->second, state);
    if (phase->has_colors()) phase->bake_colors(state, parameters);
  }
  SplatCloud cloud = to_cloud(parameters, sh_degree_of(parameters));
  cloud.filter = schedule.options.render.filter.value_or(ScreenFilter{});
  return cloud;
}

}  // namespace fluxgs
