#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "cloud/activation.h"
#include "fluxgs/io/ply.h"
#include "fluxgs/sanitize.h"
#include "io/ply/ply_columns.h"
#include "io/ply/ply_filter.h"
#include "io/ply/ply_header.h"
#include "io/ply/ply_rows.h"
#include "io/ply/ply_view.h"
#include "io/whole_cloud.h"

namespace fluxgs {
namespace {

using namespace io;

constexpr std::size_t kPlain = 14;  // properties of a splat besides f_rest_*
constexpr std::array<const char*, kPlain> kNames{
    "x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
    "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};

constexpr int kMaxStoredDegree = 4;                     // gsplat and Brush train as many
constexpr std::size_t kFirstColor = 3, kLastScale = 9;  // of kNames
constexpr float kFlat = -20;                            // log-scale of an axis without length

// Where the values of a splat stand in a row of the file: kNames, then f_rest_0 ….
struct SplatColumns {
  int sh_degree = 0;                  // as kept
  int stored_degree = 0;              // of the file, which may be higher
  std::vector<std::size_t> property;  // index among the element's properties
  bool flat = false;                  // a 2D Gaussian: scale_2 is missing
  float color_unit = 0;  // of red, green, blue, which stand for f_dc_*; 0: f_dc_* are there
};

// The name of column i in this file. 2D Gaussian Splatting (Huang et al. 2024) writes two scales;
// nerfstudio writes colours instead of SH on demand.
std::string column_name(const SplatColumns& columns, std::size_t i) {
  constexpr std::array<const char*, 3> kColors{"red", "green", "blue"};
  if (i >= kPlain) {
    const auto kept = static_cast<std::size_t>(sh_rest_count(columns.sh_degree));
    const auto stored = static_cast<std::size_t>(sh_rest_count(columns.stored_degree));
    const std::size_t channel = (i - kPlain) / kept, k = (i - kPlain) % kept;
    return fmt::format("f_rest_{}", channel * stored + k);
  }
  if (columns.color_unit > 0 && i >= kFirstColor && i < kFirstColor + 3)
    return kColors[i - kFirstColor];
  return columns.flat && i == kLastScale ? kNames[kLastScale - 1] : kNames[i];
}

// True for the points of a mesh or a point cloud.
bool is_without_splats(const PlyElement& vertex) {
  constexpr std::array<const char*, 4> kOfSplats{"f_dc_0", "opacity", "scale_0", "rot_0"};
  return has_ply_property(vertex, "x") && std::ranges::none_of(kOfSplats, [&](const char* n) {
           return has_ply_property(vertex, n);
         });
}

// With harmonics up to a degree.
Expected<SplatColumns> find_splat_columns(const PlyElement& vertex, int max_degree,
                                          const std::string& name) {
  if (vertex.has_lists()) {
    return fail(name, "element vertex", "holds a list property; expected only scalars");
  }
  if (is_without_splats(vertex))
    return fail(name, "element vertex",
                "has points without size, rotation and opacity: a mesh or a point cloud; expected "
                "the splats of a 3DGS .ply (f_dc_0, opacity, scale_0, rot_0, ...)");
  const auto degree = ply_sh_degree(vertex, kMaxStoredDegree, name);
  if (!degree) return std::unexpected(degree.error());
  SplatColumns columns;
  columns.stored_degree = *degree;
  columns.sh_degree = std::min(*degree, max_degree);
  columns.flat = has_ply_property(vertex, "scale_1") && !has_ply_property(vertex, "scale_2");
  const auto red = std::ranges::find(vertex.properties, "red", &PlyProperty::name);
  if (!has_ply_property(vertex, "f_dc_0") && red != vertex.properties.end())
    columns.color_unit = red->type == PlyType::uint8    ? 1 / 255.0F
                         : red->type == PlyType::uint16 ? 1 / 65535.0F
                                                        : 1.0F;
  const std::size_t count = kPlain + 3 * static_cast<std::size_t>(sh_rest_count(columns.sh_degree));
  for (std::size_t i = 0; i < count; ++i) {
    const auto found = find_ply_property(vertex, column_name(columns, i), "3DGS .ply", name);
    if (!found) return std::unexpected(found.error());
    columns.property.push_back(*found);
  }
  return columns;
}

// Infinite logits are what converters make of opacities of exactly 0 and 1 in 8 bits
// (splat-transform 3.7: most splats of some scenes).
float finite_logit(float value) { return std::isinf(value) ? logit_of(value > 0 ? 1 : 0) : value; }

// The logarithm of 0, which some writers store for flat splats, is a length, too.
float finite_log_scale(float value) { return value < kFlat && std::isinf(value) ? kFlat : value; }

void store(const SplatColumns& columns, const float* v, std::size_t i, SplatCloud& cloud) {
  cloud.positions[i] = {v[0], v[1], v[2]};
  cloud.sh_dc[i] = {v[3], v[4], v[5]};
  if (columns.color_unit > 0)
    for (int c = 0; c < 3; ++c)
      cloud.sh_dc[i][c] = dc_of(static_cast<double>(v[3 + c] * columns.color_unit));
  cloud.opacity_logits[i] = finite_logit(v[6]);
  cloud.log_scales[i] = {finite_log_scale(v[7]), finite_log_scale(v[8]),
                         columns.flat ? kFlat : finite_log_scale(v[9])};
  cloud.rotations[i] = glm::quat(v[10], v[11], v[12], v[13]);  // w first
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k) {
    const float* red = v + kPlain + k;  // channel-major
    cloud.sh_rest[i * rest + k] = {red[0], red[rest], red[2 * rest]};
  }
}

// The rows of the splats, which come next.
Expected<void> read_splats(PlyData& data, const PlyElement& vertex, const std::string& name,
                           SplatSink& sink, SceneFile& scene) {
  auto columns = find_splat_columns(vertex, kMaxShDegree, name);
  if (!columns) return std::unexpected(columns.error());
  if (columns->stored_degree > columns->sh_degree)
    scene.warnings.push_back(
        fmt::format("spherical harmonics beyond degree {} are left out", columns->sh_degree));
  scene.attribute_bits = float_attribute_bits(columns->sh_degree);
  if (auto there = data.check_size(vertex); !there) return there;
  const ComingSplats coming{static_cast<std::size_t>(vertex.count), columns->sh_degree};
  const auto degree = sink.begin(coming);
  if (!degree) return std::unexpected(degree.error());
  columns = find_splat_columns(vertex, *degree, name);
  if (!columns) return std::unexpected(columns.error());
  return hand_on(
      coming, columns->sh_degree, name, sink, scene, [&](std::size_t first, SplatCloud& part) {
        return data.read<float>(
            vertex, columns->property, first, part.size(),
            [&](std::size_t i, const float* values) { store(*columns, values, i - first, part); });
      });
}

Expected<void> read_elements(const ByteSource& source, const PlyHeader& header,
                             const std::string& name, SplatSink& sink, SceneFile& scene) {
  const auto vertex = std::ranges::find(header.elements, "vertex", &PlyElement::name);
  if (vertex == header.elements.end()) {
    return fail(name, "header", "has no element \"vertex\"; expected one row of it per splat");
  }
  // What is wrong with them is said before what lies in front of them is read
  if (auto sound = find_splat_columns(*vertex, kMaxShDegree, name); !sound)
    return std::unexpected(sound.error());
  PlyData data(source, header.size, header.encoding, name);
  for (auto element = header.elements.begin(); element != header.elements.end(); ++element) {
    auto done =
        element == vertex ? read_splats(data, *vertex, name, sink, scene) : data.skip(*element);
    if (!done) return done;
  }
  if (const std::uint64_t left = data.bytes_left(); left > 0)
    scene.warnings.push_back(
        fmt::format("{} bytes behind the {} splats that its header promises are not read", left,
                    vertex->count));
  return {};
}

}  // namespace

bool is_ply(std::span<const std::byte> bytes) {
  constexpr std::string_view kMagic = "ply";
  return bytes.size() > kMagic.size() &&
         std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0 &&
         (bytes[3] == std::byte{'\n'} || bytes[3] == std::byte{'\r'});
}

Expected<SceneFile> read_ply(const ByteSource& source, const std::string& name, SplatSink& sink) {
  const auto header = read_ply_header(source, name);
  if (!header) return std::unexpected(header.error());
  SceneFile scene;
  if (auto done = read_elements(source, *header, name, sink, scene); !done)
    return std::unexpected(done.error());
  scene.cloud.filter = filter_of_comments(header->comments);
  scene.start = view_of_comments(header->comments);
  scene.format = "ply";
  scene.bytes = static_cast<std::size_t>(source.size());
  return scene;
}

Expected<SceneFile> read_ply(std::span<const std::byte> bytes, const std::string& name) {
  return read_whole(name,
                    [&](SplatSink& sink) { return read_ply(MemoryBytes(bytes), name, sink); });
}

}  // namespace fluxgs
