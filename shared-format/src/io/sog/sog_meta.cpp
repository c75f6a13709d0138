#include "io/sog/sog_meta.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <fmt/format.h>

#include "cloud/activation.h"
#include "io/json_text.h"
#include "io/sog/named_files.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

// The most pixels that a WebP image can have: 16383 a side.
constexpr std::uint64_t kMaxSplats = std::uint64_t(16383) * 16383;
constexpr std::uint64_t kMaxPalette = 65536;  // section 3.5: labels have 16 bits

// Looks up members by name and keeps the first thing that is wrong.
class MetaReader {
 public:
  MetaReader(const json& root, const std::string& name, const std::string& field)
      : root_(root), name_(name), field_(field) {}

  bool failed() const { return !error_.what.empty(); }
  const Error& error() const { return error_; }

  void bad(const std::string& where, std::string what) {
    if (!failed()) error_ = {name_, field_ + ": " + where, std::move(what)};
  }

  const json& at(const char* group, const char* key) const {
    return member(member(root_, group), key);
  }

  std::size_t whole(const json& value, const std::string& where, std::uint64_t limit) {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() <= limit) {
      return static_cast<std::size_t>(value.get<std::uint64_t>());
    }
    bad(where, fmt::format("{}; expected a whole number from 0 to {}", found(value), limit));
    return 0;
  }

  double number(const json& value, const std::string& where) {
    constexpr double kMax = std::numeric_limits<float>::max();
    if (value.is_number() && std::abs(value.get<double>()) <= kMax) return value.get<double>();
    bad(where, fmt::format("{}; expected a number", found(value)));
    return 0;
  }

  // `count` numbers of a list.
  std::vector<double> numbers(const char* group, const char* key, std::size_t count) {
    const json& list = at(group, key);
    const std::string where = fmt::format("{}.{}", group, key);
    std::vector<double> result(count);
    if (!list.is_array() || list.size() != count) {
      bad(where, fmt::format("{}; expected {} numbers", found(list), count));
      return result;
    }
    for (std::size_t i = 0; i < count; ++i) {
      result[i] = number(list[i], fmt::format("{}[{}]", where, i));
    }
    return result;
  }

  std::string file(const char* group, std::size_t index) {
    const json& list = at(group, "files");
    const std::string where = fmt::format("{}.files[{}]", group, index);
    if (!list.is_array() || list.size() <= index || !list[index].is_string()) {
      bad(where, "expected the name of an image");
      return {};
    }
    const auto& file = list[index].get_ref<const std::string&>();
    if (!is_plain_name(file) && !failed()) error_ = name_error(name_, field_ + ": " + where, file);
    return file;
  }

  SogTable codebook(const char* group) {
    const json& list = at(group, "codebook");
    const std::string where = fmt::format("{}.codebook", group);
    SogTable table;
    if (!list.is_array() || list.empty() || list.size() > table.values.size()) {
      bad(where, fmt::format("{}; expected 1 to 256 numbers", found(list)));
      return table;
    }
    table.size = list.size();
    const bool lacks_first = list[0].is_null() && table.size == table.values.size();
    for (std::size_t i = lacks_first ? 1 : 0; i < table.size; ++i) {
      table.values[i] = static_cast<float>(number(list[i], fmt::format("{}[{}]", where, i)));
    }
    // Early writers left null where the first number belongs; PlayCanvas' engine continues the
    // codebook by its mean step in the same way.
    if (lacks_first) {
      const auto& v = table.values;
      table.values[0] = v[1] + (v[1] - v[255]) / 255;
    }
    return table;
  }

 private:
  const json& root_;
  const std::string& name_;
  const std::string& field_;
  Error error_;
};

template <class Value>
SogTable make_table(Value value) {
  SogTable table;
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    table.values[i] = static_cast<float>(value(static_cast<double>(i) / 255));
  }
  return table;
}

SogTable steps(double low, double high) {
  return make_table([=](double t) { return low + (high - low) * t; });
}

SogTable opacity_logits() {
  return make_table([](double opacity) { return double{logit_of(opacity)}; });
}

// The specification has "antialias", splat-transform writes "model"; "dilation" is ours, and is
// left out where it is 0.3 px².
ScreenFilter filter_of(const json& root) {
  ScreenFilter filter;
  filter.compensated = member(root, "antialias") == true || member(root, "model") == "antialiased";
  const json& dilation = member(root, "dilation");
  const double value = dilation.is_number() ? dilation.get<double>() : 0;
  if (value > 0 && value <= 100) filter.dilation = value;
  return filter;
}

// What both versions share: ranges of the positions and the names of the images.
SogMeta read_common(MetaReader& read, const json& root) {
  SogMeta meta;
  meta.filter = filter_of(root);
  const auto low = read.numbers("means", "mins", 3), high = read.numbers("means", "maxs", 3);
  meta.mean_min = {low[0], low[1], low[2]};
  meta.mean_max = {high[0], high[1], high[2]};
  meta.means = {read.file("means", 0), read.file("means", 1)};
  meta.scales_image = read.file("scales", 0);
  meta.quats_image = read.file("quats", 0);
  meta.sh0_image = read.file("sh0", 0);
  if (!member(root, "shN").is_null()) {
    meta.sh.emplace();
    meta.sh->centroids = read.file("shN", 0);
    meta.sh->labels = read.file("shN", 1);
  }
  return meta;
}

void read_version2(MetaReader& read, const json& root, SogMeta& meta) {
  meta.count = read.whole(member(root, "count"), "count", kMaxSplats);
  meta.scales.fill(read.codebook("scales"));
  meta.sh0.fill(read.codebook("sh0"));
  meta.sh0[3] = opacity_logits();
  if (!meta.sh) return;
  SogSh& sh = *meta.sh;
  sh.table = read.codebook("shN");
  if (const json& count = read.at("shN", "count"); !count.is_null()) {
    sh.count = read.whole(count, "shN.count", kMaxPalette);
  }
  if (const json& bands = read.at("shN", "bands"); !bands.is_null()) {
    sh.degree = static_cast<int>(read.whole(bands, "shN.bands", 3));
  }
  if (sh.degree == 0) meta.sh.reset();
}

// As PlayCanvas' converter reads it: 256 even steps of a range for each channel, opacities already
// as logits, the degree from the width of the palette.
void read_version1(MetaReader& read, SogMeta& meta) {
  const json& shape = read.at("means", "shape");
  meta.count = read.whole(shape.is_array() && !shape.empty() ? shape[0] : json(), "means.shape[0]",
                          kMaxSplats);
  const auto scale_low = read.numbers("scales", "mins", 3),
             scale_high = read.numbers("scales", "maxs", 3);
  for (std::size_t c = 0; c < 3; ++c) meta.scales[c] = steps(scale_low[c], scale_high[c]);
  const auto sh0_low = read.numbers("sh0", "mins", 4), sh0_high = read.numbers("sh0", "maxs", 4);
  for (std::size_t c = 0; c < 4; ++c) meta.sh0[c] = steps(sh0_low[c], sh0_high[c]);
  if (!meta.sh) return;
  meta.sh->table = steps(read.number(read.at("shN", "mins"), "shN.mins"),
                         read.number(read.at("shN", "maxs"), "shN.maxs"));
}

}  // namespace

Expected<SogMeta> parse_sog_meta(const json& root, const std::string& name,
                                 const std::string& field) {
  const json& version = member(root, "version");
  if (!version.is_null() && version != 2) {
    return fail(name, field + ": version",
                fmt::format("{}; expected 2, or none for version 1", found(version)));
  }
  MetaReader read(root, name, field);
  SogMeta meta = read_common(read, root);
  if (version.is_null()) {
    read_version1(read, meta);
  } else {
    read_version2(read, root, meta);
  }
  if (read.failed()) return std::unexpected(read.error());
  return meta;
}

}  // namespace fluxgs::io
