#include "trainer/train/checkpoint.h"

#include <algorithm>
#include <cstring>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"

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

void append_rows(std::vector<std::byte>& out, const PlanarFloats& planes) {
  for (int r = 0; r < planes.rows(); ++r) {
    const auto* p = reinterpret_cast<const std::byte*>(planes.row(r));
    out.insert(out.end(), p, p + planes.size() * sizeof(float));
  }
}

const std::byte* take_rows(const std::byte* in, PlanarFloats& planes) {
  const std::size_t bytes = planes.size() * sizeof(float);
  for (int r = 0; r < planes.rows(); ++r, in += bytes)
    if (bytes > 0) std::memcpy(planes.row(r), in, bytes);
  return in;
}

/// The steps in the order of CompactSteps; null for none.
json rounding_header(const std::optional<RoundingState>& rounding) {
  if (!rounding) return nullptr;
  const CompactSteps& s = rounding->steps;
  return {s.position, s.log_scale, s.rotation, s.opacity, s.sh_dc, s.sh_rest, s.energy};
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
          {"train_photos", c.train_photos},
          {"photos_hash", c.photos_hash},
          {"splats", c.state.parameters.size()},
          {"sh_degree", sh_degree_of(c.state.parameters)},
          {"own_degrees", !c.state.degrees.empty()},
          {"psi", c.state.networks && c.state.networks->model.psi},
          {"phi", c.state.networks && c.state.networks->model.phi},
          {"switched_at", c.state.switched_at},
          {"rounding", rounding_header(c.state.rounding)},
          {"iteration", c.state.iteration},
          {"most_pairs", c.state.most_pairs},
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
  for (const OptionField& f : option_fields()) {
    // What a checkpoint of an older version does not know is as in TrainOptions
    if (!header.at("options").contains(f.name)) continue;
    const json& value = header.at("options").at(f.name);
    if (f.integer) c.options.*f.integer = value.get<int>();
    if (f.real) c.options.*f.real = value.get<double>();
    if (f.natural) c.options.*f.natural = value.get<std::uint64_t>();
    if (f.choice.set) f.choice.set(c.options, choice_named(f, value.get<std::string>()));
  }
  for (int i = 0; i < 3; ++i)
    c.options.render.background[i] =
        header.at("background").at(static_cast<std::size_t>(i)).get<double>();
  c.preset = header.at("preset").get<std::string>();
  c.downscale = header.at("downscale").get<int>();
  c.train_photos = header.at("train_photos").get<std::size_t>();
  c.photos_hash = header.at("photos_hash").get<std::uint64_t>();
  c.state.iteration = header.at("iteration").get<int>();
  std::istringstream(header.at("random").get<std::string>()) >> c.state.random;
  c.state.view_order = header.at("view_order").get<std::vector<std::uint32_t>>();
  c.state.next_view = header.at("next_view").get<std::uint32_t>();
  c.state.switched_at = header.at("switched_at").get<int>();
  c.state.most_pairs = header.value("most_pairs", 0.0);
  c.state.rounding = read_rounding(header);
  c.history = header.value("history", "");
}

/// What follows the header, by the header's word.
struct Layout {
  std::uint64_t splats = 0;
  int sh_degree = 0;
  bool own_degrees = false, psi = false, phi = false, rounding = false;

  bool networks() const { return psi || phi; }
  std::size_t model_floats() const { return networks() ? appearance_floats(psi, phi) : 0; }
  /// Bytes, or 0 where that cannot be (too many splats).
  std::uint64_t size() const {
    if (splats > (std::uint64_t{1} << 40)) return 0;
    const int rows = 3 * row::count(sh_degree) + statistic::count +
                     (networks() ? 3 * networks::kShColumns : 0) +
                     (rounding ? row::count(sh_degree) : 0);
    const std::uint64_t floats =
        static_cast<std::uint64_t>(rows) + (rounding ? error_costs_size(sh_degree) : 0);
    return splats * (floats * sizeof(float) + (own_degrees ? 1 : 0)) +
           model_floats() * sizeof(float);
  }
};

Layout layout_of(const TrainState& state) {
  const auto& n = state.networks;
  return {state.parameters.size(), sh_degree_of(state.parameters),
          !state.degrees.empty(),  n && n->model.psi,
          n && n->model.phi,       state.rounding.has_value()};
}

Layout read_layout(const json& header) {
  const Layout layout{header.at("splats").get<std::uint64_t>(),
                      header.at("sh_degree").get<int>(),
                      header.at("own_degrees").get<bool>(),
                      header.at("psi").get<bool>(),
                      header.at("phi").get<bool>(),
                      read_rounding(header).has_value()};
  return layout.sh_degree >= 0 && layout.sh_degree <= 3 ? layout : Layout{~std::uint64_t{0}};
}

void append_state(std::vector<std::byte>& out, const TrainState& state) {
  append_rows(out, state.parameters);
  append_rows(out, state.adam.first);
  append_rows(out, state.adam.second);
  append_rows(out, state.statistics);
  if (state.rounding) {
    const ErrorCosts& costs = state.rounding->costs;
    for (const auto* numbers : {&costs.weights, &costs.sh_factors, &costs.scale, &costs.rotation})
      for (const float number : *numbers) append(out, number);
    append_rows(out, state.rounding->offsets);
  }
  for (std::uint8_t degree : state.degrees) out.push_back(static_cast<std::byte>(degree));
  if (!state.networks) return;
  append_rows(out, state.networks->latents);
  append_rows(out, state.networks->adam.first);
  append_rows(out, state.networks->adam.second);
  for (float value : to_floats(state.networks->model)) append(out, value);
}

/// `in` has layout.size() bytes.
Expected<void> take_state(const std::byte* in, const Layout& layout, TrainState& state) {
  const auto take = [&](int rows, std::initializer_list<PlanarFloats*> all) {
    for (PlanarFloats* planes : all) {
      *planes = PlanarFloats(rows, layout.splats);
      in = take_rows(in, *planes);
    }
  };
  take(row::count(layout.sh_degree), {&state.parameters, &state.adam.first, &state.adam.second});
  take(statistic::count, {&state.statistics});
  if (state.rounding) {
    ErrorCosts& costs = state.rounding->costs;
    costs.weights.resize(layout.splats);
    costs.sh_factors.resize(layout.splats * sh_factor_size(layout.sh_degree));
    costs.scale.resize(layout.splats * kTriangle3);
    costs.rotation.resize(layout.splats * kTriangle3);
    for (auto* numbers : {&costs.weights, &costs.sh_factors, &costs.scale, &costs.rotation}) {
      std::memcpy(numbers->data(), in, numbers->size() * sizeof(float));
      in += numbers->size() * sizeof(float);
    }
    take(row::count(layout.sh_degree), {&state.rounding->offsets});
  }
  if (layout.own_degrees) {
    state.degrees.resize(layout.splats);
    for (std::uint8_t& degree : state.degrees)
      degree = std::min<std::uint8_t>(std::to_integer<std::uint8_t>(*in++),
                                      static_cast<std::uint8_t>(layout.sh_degree));
  }
  if (!layout.networks()) return {};
  NetworkState networks;
  take(networks::kShColumns, {&networks.latents, &networks.adam.first, &networks.adam.second});
  std::vector<float> floats(layout.model_floats());
  std::memcpy(floats.data(), in, floats.size() * sizeof(float));
  auto model = model_from_floats(layout.psi, layout.phi, floats);
  if (!model) return std::unexpected(model.error());
  networks.model = std::move(*model);
  state.networks = std::move(networks);
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

std::uint64_t hash_photos(const std::vector<Photo>& photos) {
  std::uint64_t h = hash({});
  for (const Photo& photo : photos) {
    const Camera& c = photo.camera;
    double numbers[] = {
        c.fx, c.fy, c.cx, c.cy, c.translation.x, c.translation.y, c.translation.z, 0, 0, 0, 0, 0,
        0,    0,    0,    0};
    for (int i = 0; i < 9; ++i) numbers[7 + i] = c.rotation[i / 3][i % 3];
    h = hash(std::as_bytes(std::span(c.name)), h);
    h = hash(std::as_bytes(std::span(numbers)), h);
    h = hash(std::as_bytes(std::span(photo.rgb.pixels)), h);
  }
  return h;
}

Expected<void> write_checkpoint(const std::filesystem::path& path, const Checkpoint& c) {
  const std::string header = header_of(c).dump();
  std::vector<std::byte> out;
  out.reserve(kPrefix + header.size() + layout_of(c.state).size() + sizeof(std::uint64_t));
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
  Layout layout;
  try {
    const char* text = reinterpret_cast<const char*>(bytes->data() + kPrefix);
    const json header = json::parse(text, text + header_size);
    read_header(header, c);
    layout = read_layout(header);
  } catch (const json::exception& e) {
    return bad("header", fmt::format("is not the expected JSON ({})", e.what()));
  }
  if (auto valid = validate(c.options); !valid) return std::unexpected(valid.error());
  if (c.state.view_order.size() != c.train_photos || layout.size() != body - header_size)
    return bad("header", "counts disagree with the size of the file");
  if (auto taken = take_state(bytes->data() + kPrefix + header_size, layout, c.state); !taken)
    return bad("networks", taken.error().what);
  for (std::uint32_t view : c.state.view_order)
    if (view >= c.train_photos) return bad("view_order", "names a photo that is not there");
  return c;
}

}  // namespace fluxgs
