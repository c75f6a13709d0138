#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "networks/onnx_model.h"
#include "networks/protobuf.h"

namespace fluxgs::networks {
namespace {

static_assert(std::endian::native == std::endian::little, "raw_data is little-endian");

using Bytes = std::span<const std::byte>;

enum class Use { once, many, skipped, refused };

/// Handling of a field of a message (numbers and names: onnx.proto3).
struct Rule {
  std::uint32_t number;
  Wire wire;
  const char* name;
  Use use;
};

constexpr Rule kModelRules[] = {
    {1, Wire::varint, "ir_version", Use::once},
    {2, Wire::bytes, "producer_name", Use::skipped},
    {3, Wire::bytes, "producer_version", Use::skipped},
    {4, Wire::bytes, "domain", Use::skipped},
    {5, Wire::varint, "model_version", Use::skipped},
    {6, Wire::bytes, "doc_string", Use::skipped},
    {7, Wire::bytes, "graph", Use::once},
    {8, Wire::bytes, "opset_import", Use::once},
    {14, Wire::bytes, "metadata_props", Use::skipped},
    {20, Wire::bytes, "training_info", Use::refused},
    {25, Wire::bytes, "functions", Use::refused},
    {26, Wire::bytes, "configuration", Use::refused},
};
constexpr Rule kOpsetRules[] = {
    {1, Wire::bytes, "domain", Use::once},
    {2, Wire::varint, "version", Use::once},
};
constexpr Rule kGraphRules[] = {
    {1, Wire::bytes, "node", Use::many},
    {2, Wire::bytes, "name", Use::skipped},
    {5, Wire::bytes, "initializer", Use::many},
    {10, Wire::bytes, "doc_string", Use::skipped},
    {11, Wire::bytes, "input", Use::many},
    {12, Wire::bytes, "output", Use::many},
    {13, Wire::bytes, "value_info", Use::skipped},
    {14, Wire::bytes, "quantization_annotation", Use::refused},
    {15, Wire::bytes, "sparse_initializer", Use::refused},
    {16, Wire::bytes, "metadata_props", Use::skipped},
};
constexpr Rule kNodeRules[] = {
    {1, Wire::bytes, "input", Use::many},
    {2, Wire::bytes, "output", Use::many},
    {3, Wire::bytes, "name", Use::skipped},
    {4, Wire::bytes, "op_type", Use::once},
    {5, Wire::bytes, "attribute", Use::many},
    {6, Wire::bytes, "doc_string", Use::skipped},
    {7, Wire::bytes, "domain", Use::once},
    {8, Wire::bytes, "overload", Use::refused},
    {9, Wire::bytes, "metadata_props", Use::skipped},
    {10, Wire::bytes, "device_configurations", Use::refused},
};
constexpr Rule kAttributeRules[] = {
    {1, Wire::bytes, "name", Use::once},
    {2, Wire::fixed32, "f", Use::once},
    {3, Wire::varint, "i", Use::once},
    {4, Wire::bytes, "s", Use::refused},
    {5, Wire::bytes, "t", Use::refused},
    {6, Wire::bytes, "g (a sub-graph)", Use::refused},
    {7, Wire::bytes, "floats", Use::refused},
    {7, Wire::fixed32, "floats", Use::refused},
    {8, Wire::bytes, "ints", Use::refused},
    {8, Wire::varint, "ints", Use::refused},
    {9, Wire::bytes, "strings", Use::refused},
    {10, Wire::bytes, "tensors", Use::refused},
    {11, Wire::bytes, "graphs (sub-graphs)", Use::refused},
    {13, Wire::bytes, "doc_string", Use::skipped},
    {14, Wire::bytes, "tp", Use::refused},
    {15, Wire::bytes, "type_protos", Use::refused},
    {20, Wire::varint, "type", Use::once},
    {21, Wire::bytes, "ref_attr_name", Use::refused},
    {22, Wire::bytes, "sparse_tensor", Use::refused},
    {23, Wire::bytes, "sparse_tensors", Use::refused},
};
constexpr Rule kTensorRules[] = {
    {1, Wire::varint, "dims", Use::many},
    {1, Wire::bytes, "dims", Use::many},  // packed
    {2, Wire::varint, "data_type", Use::once},
    {3, Wire::bytes, "segment", Use::refused},
    {4, Wire::bytes, "float_data", Use::once},
    {4, Wire::fixed32, "float_data (not packed)", Use::refused},
    {5, Wire::bytes, "int32_data", Use::refused},
    {6, Wire::bytes, "string_data", Use::refused},
    {7, Wire::bytes, "int64_data", Use::refused},
    {8, Wire::bytes, "name", Use::once},
    {9, Wire::bytes, "raw_data", Use::once},
    {10, Wire::bytes, "double_data", Use::refused},
    {11, Wire::bytes, "uint64_data", Use::refused},
    {12, Wire::bytes, "doc_string", Use::skipped},
    {13, Wire::bytes, "external_data", Use::refused},
    {14, Wire::varint, "data_location", Use::once},
    {16, Wire::bytes, "metadata_props", Use::skipped},
};
constexpr Rule kValueRules[] = {
    {1, Wire::bytes, "name", Use::once},
    {2, Wire::bytes, "type", Use::once},
    {3, Wire::bytes, "doc_string", Use::skipped},
    {4, Wire::bytes, "metadata_props", Use::skipped},
};
constexpr Rule kTypeRules[] = {
    {1, Wire::bytes, "tensor_type", Use::once},
    {4, Wire::bytes, "sequence_type", Use::refused},
    {5, Wire::bytes, "map_type", Use::refused},
    {6, Wire::bytes, "denotation", Use::skipped},
    {7, Wire::bytes, "opaque_type", Use::refused},
    {8, Wire::bytes, "sparse_tensor_type", Use::refused},
    {9, Wire::bytes, "optional_type", Use::refused},
};
constexpr Rule kTensorTypeRules[] = {
    {1, Wire::varint, "elem_type", Use::once},
    {2, Wire::bytes, "shape", Use::once},
};
constexpr Rule kShapeRules[] = {
    {1, Wire::bytes, "dim", Use::many},
};
constexpr Rule kDimRules[] = {
    {1, Wire::varint, "dim_value", Use::once},
    {2, Wire::bytes, "dim_param", Use::once},
    {3, Wire::bytes, "denotation", Use::skipped},
};

/// Calls take(field) for every field of `message` that is used. Fields that are written twice
/// though they occur once, unknown ones and those of another type are refused: two programs could
/// read such a message in two ways.
template <class Take>
Expected<void> for_each_field(Bytes message, std::span<const Rule> rules, const Place& place,
                              Take take) {
  std::uint32_t seen = 0;  // one bit a rule
  for (FieldReader reader(message); !reader.done();) {
    const auto field = reader.next();
    if (!field) return fail(place, "is cut short or not a Protocol Buffers message");
    const auto rule = std::ranges::find_if(
        rules, [&](const Rule& r) { return r.number == field->number && r.wire == field->wire; });
    if (rule == rules.end()) {
      return fail(place, fmt::format("field {} of wire type {} is not one of an ONNX model that "
                                     "can be read here",
                                     field->number, static_cast<int>(field->wire)));
    }
    if (rule->use == Use::skipped) continue;
    if (rule->use == Use::refused) {
      return fail(place.in(rule->name), "not accepted in a scene's network");
    }
    const std::uint32_t bit = 1u << (rule - rules.begin());
    if (rule->use == Use::once && (seen & bit) != 0) {
      return fail(place.in(rule->name), "appears twice");
    }
    seen |= bit;
    if (auto taken = take(*field, place.in(rule->name)); !taken) return taken;
  }
  return {};
}

/// Short printable names only, so that every message that quotes one is one clear line.
Expected<void> read_name(const Field& field, std::string& name, const Place& place) {
  const std::string_view text = field.as_text();
  const bool sanitized = std::ranges::all_of(text, [](char c) { return c >= 0x20 && c <= 0x7e; });
  if (text.size() > kMaxNameLength || !sanitized) {
    return fail(place,
                fmt::format("expected at most {} characters of printable ASCII", kMaxNameLength));
  }
  name = text;
  return {};
}

/// Operators of ONNX itself: "" and "ai.onnx" are the same domain.
Expected<void> check_domain(const Field& field, const Place& place) {
  const std::string_view domain = field.as_text();
  if (domain.empty() || domain == "ai.onnx") return {};
  std::string name;
  if (auto ok = read_name(field, name, place); !ok) return ok;
  return fail(place, fmt::format("operators of the domain \"{}\" are not accepted", name));
}

/// Appends to a list unless it is full.
template <class T>
Expected<void> append(std::vector<T>& list, Expected<T> item, std::size_t most,
                      const Place& place) {
  if (!item) return std::unexpected(item.error());
  if (list.size() == most) return fail(place, fmt::format("more than {} of them", most));
  list.push_back(std::move(*item));
  return {};
}

Expected<Attribute> read_attribute(Bytes bytes, const Place& place) {
  Attribute attribute;
  std::int64_t type = 0, integer = 0;
  float real = 0;
  auto done = for_each_field(bytes, kAttributeRules, place,
                             [&](const Field& f, const Place& at) -> Expected<void> {
                               switch (f.number) {
                                 case 1:
                                   return read_name(f, attribute.name, at);
                                 case 2:
                                   real = f.as_float();
                                   break;
                                 case 3:
                                   integer = f.as_int();
                                   break;
                                 default:
                                   type = f.as_int();
                                   break;
                               }
                               return {};
                             });
  if (!done) return std::unexpected(done.error());
  if (type != kAttributeFloat && type != kAttributeInt) {
    return fail(place, fmt::format("\"{}\" is of type {}; expected a number (1 or 2)",
                                   attribute.name, type));
  }
  if (type == kAttributeFloat && !std::isfinite(real)) {
    return fail(place, fmt::format("\"{}\" is not finite", attribute.name));
  }
  if (type == kAttributeFloat) {
    attribute.value = real;
  } else {
    attribute.value = integer;
  }
  return attribute;
}

Expected<Node> read_node(Bytes bytes, const Place& place) {
  Node node;
  auto done = for_each_field(
      bytes, kNodeRules, place, [&](const Field& f, const Place& at) -> Expected<void> {
        const auto name_into = [&](std::vector<std::string>& list) {
          Expected<std::string> name;
          if (auto ok = read_name(f, *name, at); !ok) name = std::unexpected(ok.error());
          return append(list, std::move(name), kMaxOperands, at);
        };
        switch (f.number) {
          case 1:
            return name_into(node.inputs);
          case 2:
            return name_into(node.outputs);
          case 4:
            return read_name(f, node.op, at);
          case 5:
            return append(node.attributes, read_attribute(f.bytes, at), kMaxAttributes, at);
          default:
            return check_domain(f, at);
        }
      });
  if (!done) return std::unexpected(done.error());
  return node;
}

Expected<void> read_dims(const Field& field, std::vector<std::int64_t>& dims, const Place& place) {
  const auto add = [&](std::uint64_t dim) -> Expected<void> {
    if (dims.size() == kMaxRank) return fail(place, "more than 2 of them");
    if (dim < 1 || dim > std::uint64_t{kMaxColumns}) {
      return fail(place, fmt::format("is {}; expected 1 to {}", static_cast<std::int64_t>(dim),
                                     kMaxColumns));
    }
    dims.push_back(static_cast<std::int64_t>(dim));
    return {};
  };
  if (field.wire == Wire::varint) return add(field.integer);
  FieldReader packed(field.bytes);
  while (!packed.done()) {
    const auto dim = packed.take_varint();
    if (!dim) return fail(place, "is cut short");
    if (auto ok = add(*dim); !ok) return ok;
  }
  return {};
}

/// The values' bytes are checked against the dimensions before they are copied.
Expected<void> read_values(Bytes data, Tensor& tensor, const Place& place) {
  std::size_t count = 1;
  for (const std::int64_t dim : tensor.dims) count *= static_cast<std::size_t>(dim);
  if (data.size() != count * sizeof(float)) {
    return fail(place, fmt::format("holds {} bytes for {} values of float32", data.size(), count));
  }
  tensor.values.resize(count);
  std::memcpy(tensor.values.data(), data.data(), data.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(tensor.values[i])) {
      return fail(place, fmt::format("value {} is not finite", i));
    }
  }
  return {};
}

Expected<Tensor> read_tensor(Bytes bytes, const Place& place) {
  Tensor tensor;
  std::int64_t type = 0;
  std::vector<Bytes> data;  // of float_data and raw_data; exactly one may be there
  auto done = for_each_field(bytes, kTensorRules, place,
                             [&](const Field& f, const Place& at) -> Expected<void> {
                               switch (f.number) {
                                 case 1:
                                   return read_dims(f, tensor.dims, at);
                                 case 2:
                                   type = f.as_int();
                                   break;
                                 case 8:
                                   return read_name(f, tensor.name, at);
                                 case 14:
                                   if (f.integer != 0)
                                     return fail(at, "external data is not accepted");
                                   break;
                                 default:
                                   data.push_back(f.bytes);
                                   break;
                               }
                               return {};
                             });
  if (!done) return std::unexpected(done.error());
  const Place named = place.in("\"" + tensor.name + "\"");
  if (type != kFloat) {
    return fail(named, fmt::format("is of element type {}; expected 1, float32", type));
  }
  if (data.size() != 1) return fail(named, "expected its values either as raw_data or float_data");
  if (auto ok = read_values(data[0], tensor, named); !ok) return std::unexpected(ok.error());
  return tensor;
}

/// The value of a dimension; 0 if it is free: named, −1, or not said.
Expected<std::int64_t> read_dim(Bytes bytes, const Place& place) {
  std::int64_t value = 0;
  bool named = false;
  auto done = for_each_field(
      bytes, kDimRules, place, [&](const Field& f, const Place& at) -> Expected<void> {
        if (f.number == 2) {
          named = true;
          return {};
        }
        value = f.as_int() == -1 ? 0 : f.as_int();
        if (value < 0 || value > kMaxColumns) {
          return fail(at, fmt::format("is {}; expected 1 to {}", f.as_int(), kMaxColumns));
        }
        return {};
      });
  if (!done) return std::unexpected(done.error());
  if (named && value != 0) return fail(place, "has both a value and a name");
  return value;
}

Expected<std::vector<std::int64_t>> read_shape(Bytes bytes, const Place& place) {
  std::vector<std::int64_t> dims;
  auto done = for_each_field(bytes, kShapeRules, place, [&](const Field& f, const Place& at) {
    return append(dims, read_dim(f.bytes, at), kMaxRank, at);
  });
  if (!done) return std::unexpected(done.error());
  return dims;
}

Expected<std::vector<std::int64_t>> read_type(Bytes bytes, const Place& place) {
  std::vector<std::int64_t> dims;
  std::int64_t element = 0;
  const auto take_tensor = [&](const Field& f, const Place& at) -> Expected<void> {
    if (f.number == 1) {
      element = f.as_int();
      return {};
    }
    auto shape = read_shape(f.bytes, at);
    if (!shape) return std::unexpected(shape.error());
    dims = std::move(*shape);
    return {};
  };
  auto done = for_each_field(bytes, kTypeRules, place, [&](const Field& f, const Place& at) {
    return for_each_field(f.bytes, kTensorTypeRules, at, take_tensor);
  });
  if (!done) return std::unexpected(done.error());
  if (element != kFloat) {
    return fail(place, fmt::format("is of element type {}; expected 1, float32", element));
  }
  return dims;
}

/// An input or output of the graph: rows × columns.
Expected<Columns> read_matrix(Bytes bytes, const Place& place) {
  Columns columns;
  std::vector<std::int64_t> dims;
  auto done = for_each_field(bytes, kValueRules, place,
                             [&](const Field& f, const Place& at) -> Expected<void> {
                               if (f.number == 1) return read_name(f, columns.name, at);
                               auto shape = read_type(f.bytes, at);
                               if (!shape) return std::unexpected(shape.error());
                               dims = std::move(*shape);
                               return {};
                             });
  if (!done) return std::unexpected(done.error());
  if (dims.size() != 2 || dims[0] != 0 || dims[1] == 0) {
    return fail(place.in("\"" + columns.name + "\""),
                "expected a matrix with a free number of rows and a known number of columns");
  }
  columns.count = static_cast<int>(dims[1]);
  return columns;
}

Expected<void> read_graph(Bytes bytes, OnnxModel& model, const Place& place) {
  return for_each_field(bytes, kGraphRules, place, [&](const Field& f, const Place& at) {
    const auto numbered = [&](std::size_t i) {
      return Place{at.file, fmt::format("{} {}", at.field, i)};
    };
    switch (f.number) {
      case 1: {
        const Place node = numbered(model.nodes.size());
        return append(model.nodes, read_node(f.bytes, node), kMaxNodes, at);
      }
      case 5: {
        const Place tensor = numbered(model.tensors.size());
        return append(model.tensors, read_tensor(f.bytes, tensor), kMaxTensors, at);
      }
      case 11:
        return append(model.inputs, read_matrix(f.bytes, at), kMaxOperands, at);
      default:
        return append(model.outputs, read_matrix(f.bytes, at), kMaxOperands, at);
    }
  });
}

Expected<void> read_opset(Bytes bytes, std::int64_t& version, const Place& place) {
  return for_each_field(bytes, kOpsetRules, place,
                        [&](const Field& f, const Place& at) -> Expected<void> {
                          if (f.number == 1) return check_domain(f, at);
                          version = f.as_int();
                          return {};
                        });
}

Expected<void> check_range(std::int64_t value, std::int64_t least, std::int64_t most,
                           const Place& place) {
  if (value >= least && value <= most) return {};
  return fail(place, fmt::format("is {}; expected {} to {}", value, least, most));
}

}  // namespace

Expected<OnnxModel> read_onnx(Bytes bytes, const Place& place) {
  if (bytes.size() > kMaxModelBytes) {
    return fail(place, fmt::format("holds {} bytes; at most {} are accepted", bytes.size(),
                                   kMaxModelBytes));
  }
  OnnxModel model{
      .ir_version = 0, .opset = 0, .nodes = {}, .tensors = {}, .inputs = {}, .outputs = {}};
  auto done = for_each_field(bytes, kModelRules, place,
                             [&](const Field& f, const Place& at) -> Expected<void> {
                               switch (f.number) {
                                 case 1:
                                   model.ir_version = f.as_int();
                                   break;
                                 case 7:
                                   return read_graph(f.bytes, model, at);
                                 default:
                                   return read_opset(f.bytes, model.opset, at);
                               }
                               return {};
                             });
  if (!done) return std::unexpected(done.error());
  auto ok = check_range(model.ir_version, kMinIrVersion, kMaxIrVersion, place.in("ir_version"));
  if (ok) ok = check_range(model.opset, kMinOpset, kMaxOpset, place.in("opset_import"));
  if (!ok) return std::unexpected(ok.error());
  return model;
}

}  // namespace fluxgs::networks
