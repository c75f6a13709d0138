#include "io/gltf/gltf_accessor.h"

#include <cstdint>

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

Expected<std::span<const std::byte>> resolve_view(const tinygltf::Model& model, int index,
                                                  std::span<const std::byte> buffer,
                                                  const std::string& name) {
  const std::string where = fmt::format("bufferViews[{}]", index);
  if (static_cast<std::size_t>(index) >= model.bufferViews.size()) {
    return fail(name, where, "does not exist");
  }
  const tinygltf::BufferView& view = model.bufferViews[static_cast<std::size_t>(index)];
  if (view.buffer != 0) {
    return fail(name, where,
                fmt::format("is in buffer {}; only buffer 0 is inside a .glb", view.buffer));
  }
  if (view.byteOffset > buffer.size() || view.byteLength > buffer.size() - view.byteOffset) {
    return fail(name, where,
                fmt::format("{} bytes at {} are outside the buffer of {}", view.byteLength,
                            view.byteOffset, buffer.size()));
  }
  return buffer.subspan(view.byteOffset, view.byteLength);
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

Expected<GltfAttribute> resolve_accessor(const tinygltf::Model& model, int accessor,
                                         const GltfExpectation& expected,
                                         std::span<const std::byte> buffer, const std::string& name,
                                         const std::string& field) {
  if (auto ok = check_accessor(model, accessor, expected, name, field); !ok) {
    return std::unexpected(ok.error());
  }
  const std::string where = place_of(field, expected, accessor);
  const tinygltf::Accessor& a = model.accessors[static_cast<std::size_t>(accessor)];
  // Zeros by the specification, but of any number, whatever the size of the file.
  if (a.bufferView < 0) return fail(name, where, "has no bufferView; expected data");
  const auto view = resolve_view(model, a.bufferView, buffer, name);
  if (!view) return std::unexpected(view.error());
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
  const int bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType));
  const auto size = static_cast<std::size_t>(components) * static_cast<std::size_t>(bytes);
  const std::size_t given = model.bufferViews[static_cast<std::size_t>(a.bufferView)].byteStride;
  const std::size_t stride = given == 0 ? size : given;
  if (stride < size) {
    return fail(name, fmt::format("bufferViews[{}].byteStride", a.bufferView),
                fmt::format("is {}, less than the {} bytes of an element", stride, size));
  }
  if (a.byteOffset > view->size() || !fits(a.count, stride, size, view->size() - a.byteOffset)) {
    return fail(name, where,
                fmt::format("promises {} elements of {} bytes at offset {}, but its bufferView "
                            "holds {} bytes",
                            a.count, size, a.byteOffset, view->size()));
  }
  return GltfAttribute{view->data() + a.byteOffset, stride, a.count, a.componentType, a.normalized};
}

}  // namespace fluxgs::io
