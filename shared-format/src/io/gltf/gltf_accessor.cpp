#include "io/gltf/gltf_accessor.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <tiny_gltf.h>

namespace fluxgs::io {
namespace {

const char* type_name(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return "SCALAR";
    case TINYGLTF_TYPE_VEC2:
      return "VEC2";
    case TINYGLTF_TYPE_VEC3:
      return "VEC3";
    case TINYGLTF_TYPE_VEC4:
      return "VEC4";
    default:
      return "a matrix";
  }
}

std::string component_name(int component, bool normalized) {
  const char* name = "32-bit integer or double";
  switch (component) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return "float";
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      name = "signed byte";
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      name = "unsigned byte";
      break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      name = "signed short";
      break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      name = "unsigned short";
      break;
    default:
      break;
  }
  return fmt::format("{}{}", normalized ? "normalised " : "", name);
}

unsigned component_bit(int component, bool normalized) {
  switch (component) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return kFloat;
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return normalized ? kSignedNormalized : kSigned;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return normalized ? kUnsignedNormalized : kUnsigned;
    default:
      return 0;
  }
}

std::string expected_types(const GltfExpectation& expected) {
  std::string types;
  const auto add = [&](unsigned bit, const char* what) {
    if ((expected.components & bit) != 0)
      types += fmt::format("{}{}", types.empty() ? "" : ", ", what);
  };
  add(kFloat, "float");
  add(kSignedNormalized, "normalised signed byte or short");
  add(kSigned, "signed byte or short");
  add(kUnsignedNormalized, "normalised unsigned byte or short");
  add(kUnsigned, "unsigned byte or short");
  return fmt::format("{} of {}", type_name(expected.type), types);
}

// Whether count elements of `size` bytes, `stride` apart, fit into `room`. No product overflows:
// count is compared with what fits.
bool fits(std::uint64_t count, std::uint64_t stride, std::uint64_t size, std::uint64_t room) {
  if (count == 0) return true;
  return size <= room && count - 1 <= (room - size) / stride;
}

std::string place_of(const std::string& field, const GltfExpectation& expected, int accessor) {
  return fmt::format("{}: {}: accessor {}", field, expected.semantic, accessor);
}

}  // namespace

Expected<GltfView> find_view(const tinygltf::Model& model, int index, GltfBuffers& buffers,
                             const std::string& name) {
  const std::string where = fmt::format("bufferViews[{}]", index);
  if (static_cast<std::size_t>(index) >= model.bufferViews.size()) {
    return fail(name, where, "does not exist");
  }
  const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(index)];
  const auto buffer = static_cast<std::size_t>(view.buffer);
  const auto size = buffers.size(buffer);
  if (!size) return std::unexpected(size.error());
  if (view.byteOffset > *size || view.byteLength > *size - view.byteOffset) {
    return fail(name, where,
                fmt::format("{} bytes at {} are outside the buffer of {}", view.byteLength,
                            view.byteOffset, *size));
  }
  return GltfView{buffer, view.byteOffset, view.byteLength};
}

Expected<std::span<const std::byte>> resolve_view(const tinygltf::Model& model, int index,
                                                  GltfBuffers& buffers, const std::string& name) {
  const auto view = find_view(model, index, buffers, name);
  if (!view) return std::unexpected(view.error());
  const auto buffer = buffers.get(view->buffer);
  return buffer ? buffer->subspan(view->offset, view->bytes) : buffer;
}

Expected<void> check_accessor(const tinygltf::Model& model, int accessor,
                              const GltfExpectation& expected, const std::string& name,
                              const std::string& field) {
  const std::string where = place_of(field, expected, accessor);
  if (static_cast<std::size_t>(accessor) >= model.accessors.size()) {
    return fail(name, where, "does not exist");
  }
  const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(accessor)];
  const unsigned bit = component_bit(a.componentType, a.normalized);
  if (a.type == expected.type && (bit & expected.components) != 0) return {};
  return fail(name, where,
              fmt::format("is {} of {}; expected {}", type_name(a.type),
                          component_name(a.componentType, a.normalized), expected_types(expected)));
}

namespace {

std::size_t element_size(const tinygltf::Accessor& a) {
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
  const int bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType));
  return static_cast<std::size_t>(components) * static_cast<std::size_t>(bytes);
}

struct Elements {
  std::size_t offset, count, stride, size;
};

Expected<void> check_elements(std::span<const std::byte> view, const Elements& e,
                              const std::string& name, const std::string& where) {
  if (e.offset <= view.size() && fits(e.count, e.stride, e.size, view.size() - e.offset)) return {};
  return fail(name, where,
              fmt::format("promises {} elements of {} bytes at offset {}, but its bufferView "
                          "holds {} bytes",
                          e.count, e.size, e.offset, view.size()));
}

// An accessor without a bufferView is zeros (glTF 2.0, 3.6.2.1), of as many elements as it says: no
// more than the file has bytes, of which the positions of as many splats take at least three.
Expected<GltfAttribute> zeros(const tinygltf::Accessor& a, GltfBuffers& buffers,
                              const std::string& name, const std::string& where) {
  static constexpr std::array<std::byte, 64> kZeros{};
  if (a.count > buffers.bytes())
    return fail(name, where,
                fmt::format("promises {} zeros in a file of {} bytes", a.count, buffers.bytes()));
  return GltfAttribute{kZeros.data(), 0, a.count, a.componentType, a.normalized};
}

Expected<GltfAttribute> resolve_elements(const tinygltf::Model& model, const tinygltf::Accessor& a,
                                         GltfBuffers& buffers, const std::string& name,
                                         const std::string& where) {
  const auto view = resolve_view(model, a.bufferView, buffers, name);
  if (!view) return std::unexpected(view.error());
  const std::size_t size = element_size(a);
  const std::size_t given = model.bufferViews[static_cast<std::size_t>(a.bufferView)].byteStride;
  const std::size_t stride = given == 0 ? size : given;
  if (stride < size) {
    return fail(name, fmt::format("bufferViews[{}].byteStride", a.bufferView),
                fmt::format("is {}, less than the {} bytes of an element", stride, size));
  }
  const Elements elements{a.byteOffset, a.count, stride, size};
  if (auto ok = check_elements(*view, elements, name, where); !ok)
    return std::unexpected(ok.error());
  return GltfAttribute{view->data() + a.byteOffset, stride, a.count, a.componentType, a.normalized};
}

// `count` elements of `size` bytes behind `offset` of a bufferView, close together.
Expected<std::span<const std::byte>> packed_elements(const tinygltf::Model& model, int view_index,
                                                     std::size_t offset, std::size_t count,
                                                     std::size_t size, GltfBuffers& buffers,
                                                     const std::string& name,
                                                     const std::string& where) {
  const auto view = resolve_view(model, view_index, buffers, name);
  if (!view) return view;
  if (auto ok = check_elements(*view, {offset, count, size, size}, name, where); !ok)
    return std::unexpected(ok.error());
  return view->subspan(offset, count * size);
}

// A copy of the elements in which some are replaced (glTF 2.0, 3.6.2.3).
Expected<GltfAttribute> with_sparse_elements(const tinygltf::Model& model,
                                             const tinygltf::Accessor& a, const GltfAttribute& base,
                                             GltfBuffers& buffers, std::size_t& sparse_bytes,
                                             const std::string& name, const std::string& where) {
  const std::size_t size = element_size(a), count = static_cast<std::size_t>(a.sparse.count);
  const int type = a.sparse.indices.componentType;
  const bool unsigned_type = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                             type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                             type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  if (!unsigned_type)
    return fail(name, where + ".sparse", "expected indices of unsigned bytes, shorts or integers");
  const auto index_size =
      static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
  const auto indices =
      packed_elements(model, a.sparse.indices.bufferView, a.sparse.indices.byteOffset, count,
                      index_size, buffers, name, where + ".sparse.indices");
  if (!indices) return std::unexpected(indices.error());
  const auto values = packed_elements(model, a.sparse.values.bufferView, a.sparse.values.byteOffset,
                                      count, size, buffers, name, where + ".sparse.values");
  if (!values) return std::unexpected(values.error());
  if (base.count > (64 * buffers.bytes() - sparse_bytes) / size)
    return fail(name, where, "sparse accessors unfold to more than 64 times the file");
  sparse_bytes += base.count * size;
  auto owned = std::make_shared<std::vector<std::byte>>(base.count * size);
  for (std::size_t i = 0; i < base.count; ++i)
    std::memcpy(owned->data() + i * size, base.data + i * base.stride, size);
  for (std::size_t k = 0; k < count; ++k) {
    std::uint32_t index = 0;  // little-endian, as this machine is (byte_reader.h)
    std::memcpy(&index, indices->data() + k * index_size, index_size);
    if (index >= base.count)
      return fail(name, where + ".sparse",
                  fmt::format("replaces element {} of {}", index, base.count));
    std::memcpy(owned->data() + index * size, values->data() + k * size, size);
  }
  return GltfAttribute{owned->data(), size, base.count, a.componentType, a.normalized, owned};
}

}  // namespace

Expected<GltfAttribute> resolve_accessor(const tinygltf::Model& model, int accessor,
                                         const GltfExpectation& expected, GltfBuffers& buffers,
                                         std::size_t& sparse_bytes, const std::string& name,
                                         const std::string& field) {
  if (auto ok = check_accessor(model, accessor, expected, name, field); !ok) {
    return std::unexpected(ok.error());
  }
  const std::string where = place_of(field, expected, accessor);
  const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(accessor)];
  auto base = a.bufferView < 0 ? zeros(a, buffers, name, where)
                               : resolve_elements(model, a, buffers, name, where);
  if (!base || !a.sparse.isSparse) return base;
  return with_sparse_elements(model, a, *base, buffers, sparse_bytes, name, where);
}

}  // namespace fluxgs::io
