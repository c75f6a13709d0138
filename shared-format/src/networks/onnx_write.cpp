#include "networks/onnx_model.h"
#include "networks/protobuf.h"

namespace fluxgs::networks {
namespace {

FieldWriter tensor_message(const Tensor& tensor) {
  FieldWriter out;
  for (const std::int64_t dim : tensor.dims) out.integer(1, dim);
  out.integer(2, kFloat);
  out.text(8, tensor.name);
  out.bytes(9, std::as_bytes(std::span(tensor.values)));
  return out;
}

FieldWriter attribute_message(const Attribute& attribute) {
  FieldWriter out;
  out.text(1, attribute.name);
  if (const float* real = std::get_if<float>(&attribute.value)) {
    out.real(2, *real);
    out.integer(20, kAttributeFloat);
  } else {
    out.integer(3, std::get<std::int64_t>(attribute.value));
    out.integer(20, kAttributeInt);
  }
  return out;
}

FieldWriter node_message(const Node& node) {
  FieldWriter out;
  for (const std::string& name : node.inputs) out.text(1, name);
  for (const std::string& name : node.outputs) out.text(2, name);
  out.text(4, node.op);
  for (const Attribute& attribute : node.attributes) out.message(5, attribute_message(attribute));
  return out;
}

// A float matrix with any number of rows: TypeProto within ValueInfoProto.
FieldWriter matrix_message(const Columns& columns) {
  FieldWriter rows, width, shape, tensor, type, out;
  rows.text(2, "N");
  width.integer(1, columns.count);
  shape.message(1, rows);
  shape.message(1, width);
  tensor.integer(1, kFloat);
  tensor.message(2, shape);
  type.message(1, tensor);
  out.text(1, columns.name);
  out.message(2, type);
  return out;
}

}  // namespace

std::vector<std::byte> write_onnx(const OnnxModel& model) {
  FieldWriter graph, opset, out;
  for (const Node& node : model.nodes) graph.message(1, node_message(node));
  graph.text(2, "network");
  for (const Tensor& tensor : model.tensors) graph.message(5, tensor_message(tensor));
  for (const Columns& input : model.inputs) graph.message(11, matrix_message(input));
  for (const Columns& output : model.outputs) graph.message(12, matrix_message(output));
  opset.text(1, "");
  opset.integer(2, model.opset);
  out.integer(1, model.ir_version);
  out.text(2, "fluxgs");
  out.message(7, graph);
  out.message(8, opset);
  return out.take();
}

}  // namespace fluxgs::networks
