#include "io/gltf/gltf_document.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>
#include <tiny_gltf.h>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat4x4.hpp>

#include "fluxgs/sanitize.h"
#include "fluxgs/splat_cloud.h"
#include "io/gltf/glb_container.h"
#include "io/gltf/gltf_accessor.h"
#include "io/gltf/gltf_compact.h"
#include "io/gltf/gltf_compressed.h"
#include "io/gltf/gltf_spz.h"
#include "io/json_text.h"

namespace fluxgs::io {
namespace {

// Stretched by less, a splat's colours are as good as turned.
constexpr double kVisibleStretch = 1.01;

constexpr std::array<std::string_view, 1> kKernels{"ellipse"};
// The names of the extension, and those of its drafts.
constexpr std::array<std::string_view, 3> kEncoded{"srgb_rec709_display", "BT.709-srgb", "BT.709"};
constexpr std::array<std::string_view, 3> kLinear{"lin_rec709_display", "BT.709-linear", "linear"};

constexpr GltfExpectation kPosition{
    "POSITION", TINYGLTF_TYPE_VEC3,
    // Integers by KHR_mesh_quantization.
    kFloat | kSigned | kSignedNormalized | kUnsigned | kUnsignedNormalized};
// The extension's table of attributes. Its early drafts stored the logarithm of the scale and
// allowed signed integers for it; those must not be taken for linear ones.
constexpr GltfExpectation kRotation{"KHR_gaussian_splatting:ROTATION", TINYGLTF_TYPE_VEC4,
                                    kFloat | kSignedNormalized};
constexpr GltfExpectation kScale{"KHR_gaussian_splatting:SCALE", TINYGLTF_TYPE_VEC3,
                                 kFloat | kUnsigned | kUnsignedNormalized};
constexpr GltfExpectation kOpacity{"KHR_gaussian_splatting:OPACITY", TINYGLTF_TYPE_SCALAR,
                                   kFloat | kUnsignedNormalized};

Expected<tinygltf::Model> load_model(const std::string& reduced, const std::string& name) {
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({});  // nothing outside of memory
  loader.RemoveImageLoader();
  tinygltf::Model model;
  std::string error, warning;
  try {
    if (loader.LoadASCIIFromString(&model, &error, &warning, reduced.data(),
                                   static_cast<unsigned>(reduced.size()), "")) {
      return model;
    }
  } catch (const std::exception& thrown) {
    error = thrown.what();
  }
  std::ranges::replace(error, '\n', ' ');
  return fail(name, "JSON", "is not a glTF document: " + sanitized(error, 200));
}

// Reads the primitives of one document; every failure names the primitive.
class PrimitiveReader {
 public:
  PrimitiveReader(const tinygltf::Model& model, GltfBuffers& buffers, const std::string& name)
      : model_(model), buffers_(buffers), name_(name) {}

  Expected<GltfSplats> read(const tinygltf::Primitive& primitive, const std::string& field) const {
    if (auto ok = check_kind(primitive, field); !ok) return std::unexpected(ok.error());
    const tinygltf::Value& extension = primitive.extensions.at(kSplatExtension);
    auto splats = extension.Has(kCompression) ? read_compressed(primitive, extension, field)
                                              : read_plain(primitive, field);
    if (splats && extension.Has(kColorSpace))
      splats->linear_colours = is_linear(extension.Get(kColorSpace).Get<std::string>());
    return splats;
  }

 private:
  Expected<GltfSplats> read_compressed(const tinygltf::Primitive& primitive,
                                       const tinygltf::Value& extension,
                                       const std::string& field) const {
    const GltfCompressedPlace place{model_, primitive, buffers_, name_, field};
    const std::string& compression = extension.Get(kCompression).Get<std::string>();
    return compression == kCompactExtension
               ? find_compact_splats(place, extension)
               : find_spz_splats(place, extension.Get(kCompressedView).GetNumberAsInt(),
                                 compression);
  }

  Expected<GltfSplats> read_plain(const tinygltf::Primitive& primitive,
                                  const std::string& field) const {
    GltfSplats splats;
    for (const auto& [target, expected] :
         {std::pair(&splats.position, kPosition), std::pair(&splats.rotation, kRotation),
          std::pair(&splats.scale, kScale), std::pair(&splats.opacity, kOpacity)}) {
      auto attribute = resolve(primitive, expected, splats, field);
      if (!attribute) return std::unexpected(attribute.error());
      *target = *attribute;
      if (target == &splats.position) splats.count = attribute->count;
    }
    if (auto ok = read_sh(primitive, field, splats); !ok) {
      return std::unexpected(ok.error());
    }
    return splats;
  }

  static bool is_linear(const std::string& color_space) {
    return std::ranges::find(kLinear, color_space) != kLinear.end();
  }

  Expected<void> check_kind(const tinygltf::Primitive& primitive, const std::string& field) const {
    if (primitive.mode != TINYGLTF_MODE_POINTS) {
      return fail(name_, field, fmt::format("has mode {}; splats need POINTS (0)", primitive.mode));
    }
    const tinygltf::Value& extension = primitive.extensions.at(kSplatExtension);
    const auto check = [&](const char* key, const auto& known) -> Expected<void> {
      // The drafts had defaults, the first of each.
      if (!extension.Has(key)) return {};
      const auto& value = extension.Get(key).Get<std::string>();
      if (std::ranges::find(known, value) != known.end()) return {};
      return fail(name_, fmt::format("{}: {}", field, key),
                  fmt::format("\"{}\" is not supported; expected \"{}\"", sanitized(value),
                              fmt::join(known, "\" or \"")));
    };
    if (auto ok = check(kKernel, kKernels); !ok) return ok;
    std::vector<std::string_view> spaces(kEncoded.begin(), kEncoded.end());
    spaces.insert(spaces.end(), kLinear.begin(), kLinear.end());
    return check(kColorSpace, spaces);
  }

  Expected<GltfAttribute> resolve(const tinygltf::Primitive& primitive,
                                  const GltfExpectation& expected, const GltfSplats& splats,
                                  const std::string& field) const {
    const auto found = primitive.attributes.find(expected.semantic);
    if (found == primitive.attributes.end()) {
      return fail(name_, field, fmt::format("attribute {} is missing", expected.semantic));
    }
    auto attribute =
        resolve_accessor(model_, found->second, expected, buffers_, sparse_bytes_, name_, field);
    if (attribute && expected.semantic != kPosition.semantic && attribute->count != splats.count) {
      return fail(
          name_, fmt::format("{}: {}", field, expected.semantic),
          fmt::format("has {} elements, but POSITION has {}", attribute->count, splats.count));
    }
    return attribute;
  }

  // A degree that is begun must be complete, and so must all below it.
  Expected<void> read_sh(const tinygltf::Primitive& primitive, const std::string& field,
                         GltfSplats& splats) const {
    splats.sh_degree = highest_degree(primitive);
    std::size_t slot = 0;
    for (int degree = 0; degree <= splats.sh_degree; ++degree) {
      for (int i = 0; i <= 2 * degree; ++i) {
        const std::string semantic =
            fmt::format("KHR_gaussian_splatting:SH_DEGREE_{}_COEF_{}", degree, i);
        const auto attribute =
            resolve(primitive, {semantic.c_str(), TINYGLTF_TYPE_VEC3, kFloat}, splats, field);
        if (!attribute) return std::unexpected(attribute.error());
        splats.sh[slot++] = *attribute;
      }
    }
    return {};
  }

  const tinygltf::Model& model_;
  GltfBuffers& buffers_;
  const std::string& name_;
  mutable std::size_t sparse_bytes_ = 0;
};

// By section 3.5.3 of glTF. Some writers round rotations or scale them, so they are normalized.
Expected<glm::dmat4> local_matrix(const tinygltf::Node& node, const std::string& name,
                                  const std::string& field) {
  glm::dmat4 m(1.0);
  if (node.matrix.size() == 16) {
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    constexpr double kRounding = 1e-5;
    if (glm::distance(glm::row(m, 3), glm::dvec4(0, 0, 0, 1)) <= kRounding) return m;
    return fail(name, field + ".matrix",
                "is not affine; expected columns, whose last elements are 0, 0, 0 and 1");
  }
  const auto& t = node.translation;
  const auto& r = node.rotation;
  const auto& s = node.scale;
  if (t.size() == 3) m = glm::translate(m, glm::dvec3(t[0], t[1], t[2]));
  if (r.size() == 4) {
    const glm::dquat q(r[3], r[0], r[1], r[2]);  // stored xyzw
    const double length = glm::length(q);
    if (!(length > 0 && std::isfinite(length)))
      return fail(name, field + ".rotation", "has no direction; expected a unit quaternion");
    m *= glm::mat4_cast(q / length);
  }
  if (s.size() == 3) m = glm::scale(m, glm::dvec3(s[0], s[1], s[2]));
  return m;
}

Expected<AffineMap> affine_map(const Expected<glm::dmat4>& given, const std::string& name,
                               const std::string& field) {
  if (!given) return std::unexpected(given.error());
  const glm::dmat4& matrix = *given;
  const AffineMap map{glm::dmat3(matrix), glm::dvec3(matrix[3])};
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k)
      if (!std::isfinite(matrix[i][k])) return fail(name, field, "its transform is not finite");
  if (std::isfinite(stretch_of(map.linear))) return map;
  return fail(name, field, "its transform flattens its splats; expected no scale of 0");
}

std::vector<int> root_nodes(const tinygltf::Model& model) {
  if (!model.scenes.empty()) return model.scenes[0].nodes;
  std::vector<bool> is_child(model.nodes.size());
  for (const tinygltf::Node& node : model.nodes) {
    for (const int child : node.children) {
      if (static_cast<std::size_t>(child) < is_child.size()) {
        is_child[static_cast<std::size_t>(child)] = true;
      }
    }
  }
  std::vector<int> roots;
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

bool has_splat_attributes(const tinygltf::Primitive& primitive) {
  return primitive.attributes.contains(kScale.semantic) &&
         primitive.attributes.contains(kRotation.semantic);
}

// The chunks of a mesh lie in the order of their numbers, so that the first bytes of a file hold
// the first ones.
class ChunkOrder {
 public:
  Expected<void> add(const GltfSplats& splats, const std::string& name, const std::string& field) {
    const std::size_t chunk = splats.chunk;
    const GltfView& view = splats.compressed;
    if (chunk != last_ && chunk != next_)
      return fail(name, field,
                  fmt::format("is of chunk {}; expected {}", chunk,
                              last_ ? fmt::format("{} or {}", *last_, next_) : "0, as the first"));
    if (chunk == next_) behind_ = end_;
    last_ = chunk;
    next_ = chunk + 1;
    if (chunk > 0 && (view.buffer != 0 || view.offset < behind_))
      return fail(
          name, field,
          fmt::format("of chunk {} lies at {} of buffer {}; expected in buffer 0 behind the "
                      "chunk before, which ends at {}",
                      chunk, view.offset, view.buffer, behind_));
    end_ = std::max(end_, view.end());
    return {};
  }

 private:
  std::optional<std::size_t> last_;
  std::size_t next_ = 0, behind_ = 0, end_ = 0;
};

// Walks the nodes, parents first, and collects what their meshes hold.
class Walk {
 public:
  Walk(const tinygltf::Model& model, const PrimitiveReader& reader, const std::string& name)
      : model_(model), reader_(reader), name_(name), visited_(model.nodes.size()) {}

  Expected<std::vector<GltfInstance>> run(const std::vector<int>& roots) {
    push(roots, glm::dmat4(1.0));
    while (!pending_.empty()) {
      const auto [index, parent] = pending_.back();
      pending_.pop_back();
      if (auto ok = visit(index, parent); !ok) return std::unexpected(ok.error());
    }
    return std::move(instances_);
  }

 private:
  void push(const std::vector<int>& nodes, const Expected<glm::dmat4>& parent) {
    // Backwards, so that the first is taken first.
    for (auto i = nodes.rbegin(); i != nodes.rend(); ++i) pending_.emplace_back(*i, parent);
  }

  Expected<void> visit(int index, const Expected<glm::dmat4>& parent) {
    const std::string field = fmt::format("nodes[{}]", index);
    const auto at = static_cast<std::size_t>(index);
    if (at >= model_.nodes.size()) return fail(name_, field, "does not exist");
    // Each node has one parent (glTF, section 3.5.2); this also ends cycles.
    if (visited_[at]) return fail(name_, field, "is reached twice; expected a tree of nodes");
    visited_[at] = true;
    const tinygltf::Node& node = model_.nodes[at];
    Expected<glm::dmat4> matrix = parent ? local_matrix(node, name_, field) : parent;
    if (parent && matrix) *matrix = *parent * *matrix;
    if (node.mesh >= 0) {
      if (auto ok = take_mesh(static_cast<std::size_t>(node.mesh), matrix, field); !ok) return ok;
    }
    push(node.children, matrix);
    return {};
  }

  /// A matrix that is none matters only where there are splats.
  Expected<void> take_mesh(std::size_t mesh, const Expected<glm::dmat4>& matrix,
                           const std::string& field) {
    if (mesh >= model_.meshes.size()) {
      return fail(name_, field, fmt::format("mesh {} does not exist", mesh));
    }
    const auto& primitives = model_.meshes[mesh].primitives;
    ChunkOrder order;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      if (!primitives[i].extensions.contains(kSplatExtension)) {
        if (has_splat_attributes(primitives[i]))
          return fail(name_, field_of(mesh, i),
                      fmt::format("has attributes of splats without the extension {}; expected it "
                                  "in \"extensions\"",
                                  kSplatExtension));
        continue;
      }
      auto splats = reader_.read(primitives[i], field_of(mesh, i));
      if (!splats) return std::unexpected(splats.error());
      const auto transform = affine_map(matrix, name_, field);
      if (!transform) return std::unexpected(transform.error());
      if (auto ok = order.add(*splats, name_, field_of(mesh, i)); !ok) return ok;
      instances_.push_back({*splats, *transform});
      if (instances_.size() > kMaxInstances) {
        return fail(name_, field, fmt::format("more than {} instances of splats", kMaxInstances));
      }
    }
    return {};
  }

  static std::string field_of(std::size_t mesh, std::size_t primitive) {
    return fmt::format("meshes[{}].primitives[{}]", mesh, primitive);
  }

  static constexpr std::size_t kMaxInstances = 65536;
  const tinygltf::Model& model_;
  const PrimitiveReader& reader_;
  const std::string& name_;
  std::vector<bool> visited_;
  std::vector<std::pair<int, Expected<glm::dmat4>>> pending_;
  std::vector<GltfInstance> instances_;
};

Expected<std::vector<GltfInstance>> find_splats(const std::string& reduced, GltfBuffers& buffers,
                                                const std::string& name) {
  const auto model = load_model(reduced, name);
  if (!model) return std::unexpected(model.error());
  const PrimitiveReader reader(*model, buffers, name);
  std::vector<int> roots = root_nodes(*model);
  if (model->defaultScene >= 0) {
    const auto scene = static_cast<std::size_t>(model->defaultScene);
    if (scene >= model->scenes.size()) {
      return fail(name, "scene", fmt::format("scene {} does not exist", scene));
    }
    roots = model->scenes[scene].nodes;
  }
  return Walk(*model, reader, name).run(roots);
}

std::vector<std::string> warnings_of(const std::vector<GltfInstance>& instances) {
  std::vector<std::string> warnings;
  const bool stretched = std::ranges::any_of(instances, [](const GltfInstance& instance) {
    return instance.splats.sh_degree > 0 && stretch_of(instance.transform.linear) > kVisibleStretch;
  });
  if (stretched)
    warnings.emplace_back(
        "its nodes stretch splats: their shapes are exact, but colours that depend on the "
        "direction "
        "of view are approximate");
  if (std::ranges::any_of(instances, [](const auto& i) { return i.splats.linear_colours; }))
    warnings.emplace_back(
        "its colours are linear and become sRGB splat by splat, which looks alike but where splats "
        "of different colours blend");
  return warnings;
}

/// The text of a .gltf.
Expected<GlbChunks> whole_text(const ByteSource& file, std::vector<std::byte>& room) {
  const auto text = file.read(0, static_cast<std::size_t>(file.size()), room);
  if (!text) return std::unexpected(text.error());
  return GlbChunks{.json = as_text(*text), .behind = file.size()};
}

}  // namespace

Expected<GltfDocument> open_gltf(const ByteSource& file, NamedFiles files,
                                 const std::string& name) {
  GltfSource source{.bin = {},
                    .data_uris = {},
                    .files = std::move(files),
                    .document = static_cast<std::size_t>(file.size())};
  std::vector<std::byte> room;
  const auto glb = begins_as_glb(file);
  if (!glb) return std::unexpected(glb.error());
  const auto chunks = *glb ? parse_glb_container(file, name, room) : whole_text(file, room);
  if (!chunks) return std::unexpected(chunks.error());
  if (*glb) source.bin = GltfBin{&file, chunks->bin_at, chunks->bin_bytes};
  const std::string rest = take_data_uris(chunks->json, source.data_uris);
  auto found = check_gltf_json(rest, name);
  if (!found) return std::unexpected(found.error());
  GltfBuffers buffers(found->buffers, std::move(source), name);
  auto instances = find_splats(found->reduced, buffers, name);
  if (!instances) return std::unexpected(instances.error());
  std::vector<std::string> warnings = warnings_of(*instances);
  warnings.insert(warnings.end(), found->warnings.begin(), found->warnings.end());
  return GltfDocument{std::move(*found),     *chunks,
                      std::move(room),       std::move(buffers),
                      std::move(*instances), std::move(warnings)};
}

}  // namespace fluxgs::io
