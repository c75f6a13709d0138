// Which graphs are networks of the expected shape.
#include "networks/onnx_check.h"

#include "tests/unit/shared-format/networks/support.h"

namespace fluxgs::networks {
namespace {

using test::expect_error;
using Ints = std::vector<std::int64_t>;

Tensor constant(const std::string& name, const Ints& dims) {
  std::size_t count = 1;
  for (const std::int64_t dim : dims) count *= static_cast<std::size_t>(dim);
  return {name, dims, std::vector<float>(count, 1.0f)};
}

Attribute whole(const std::string& name, std::int64_t value) { return {name, value}; }

// x[N,3] and z[N,2] → y
OnnxModel graph(std::vector<Node> nodes, std::vector<Tensor> tensors = {}, int outputs = 3) {
  OnnxModel model;
  model.nodes = std::move(nodes);
  model.tensors = std::move(tensors);
  model.inputs = {{"x", 3}, {"z", 2}};
  model.outputs = {{"y", outputs}};
  return model;
}

Expected<RowCost> check(const OnnxModel& model) {
  return check_onnx(model, {{{"x", 3}, {"z", 2}}, model.outputs[0]}, {"scene.glb", "network"});
}
Expected<RowCost> check(Node node, std::vector<Tensor> tensors = {}, int outputs = 3) {
  return check(graph({std::move(node)}, std::move(tensors), outputs));
}

TEST(OnnxCheck, FollowsColumnsThroughEveryOperator) {
  const auto accepts = [](const Node& node, std::vector<Tensor> tensors, int outputs,
                          std::uint64_t work) {
    const auto cost = check(node, std::move(tensors), outputs);
    ASSERT_TRUE(cost) << node.op << ": " << cost.error().message();
    EXPECT_EQ(cost->work, work) << node.op;
    EXPECT_EQ(cost->columns, 5u + static_cast<unsigned>(outputs)) << node.op;
  };
  accepts({"MatMul", {"x", "w"}, {"y"}, {}}, {constant("w", {3, 7})}, 7, 21);
  accepts({"Gemm", {"x", "w"}, {"y"}, {}}, {constant("w", {3, 7})}, 7, 21);
  accepts({"Gemm", {"x", "w", "b"}, {"y"}, {whole("transB", 1), {"alpha", 2.0f}}},
          {constant("w", {7, 3}), constant("b", {7})}, 7, 21);
  accepts({"Gemm", {"x", "w", ""}, {"y"}, {}}, {constant("w", {3, 7})}, 7, 21);
  for (const char* op : {"Add", "Sub", "Mul", "Div"}) {
    accepts({op, {"x", "x"}, {"y"}, {}}, {}, 3, 3);
    accepts({op, {"x", "c"}, {"y"}, {}}, {constant("c", {3})}, 3, 3);
    accepts({op, {"c", "x"}, {"y"}, {}}, {constant("c", {1, 3})}, 3, 3);
    accepts({op, {"x", "c"}, {"y"}, {}}, {constant("c", {})}, 3, 3);
  }
  for (const char* op : {"Relu", "Identity", "LeakyRelu"}) {
    accepts({op, {"z"}, {"y"}, {}}, {}, 2, 2);
  }
  for (const char* op : {"Sigmoid", "Tanh"}) accepts({op, {"z"}, {"y"}, {}}, {}, 2, 32);
  accepts({"Clip", {"x", "", "c"}, {"y"}, {}}, {constant("c", {})}, 3, 3);
  accepts({"Concat", {"x", "z", "x"}, {"y"}, {whole("axis", 1)}}, {}, 8, 8);
  accepts({"Concat", {"z", "x"}, {"y"}, {whole("axis", -1)}}, {}, 5, 5);
}

TEST(OnnxCheck, RefusesOtherOperators) {
  for (const char* op : {"If", "Loop", "Scan", "Conv", "Constant", "RandomNormal", "Gather",
                         "Reshape", "Expand", "Tile", "ai.onnx.Relu", "relu", ""}) {
    expect_error(check({op, {"x"}, {"y"}, {}}),
                 {"scene.glb: network: node 0 (" + std::string(op) + ")", "not accepted"});
  }
}

TEST(OnnxCheck, RefusesToMixSplats) {
  const auto w = constant("w", {3, 3});
  expect_error(check({"Gemm", {"x", "w"}, {"y"}, {whole("transA", 1)}}, {w}), {"transA"});
  expect_error(check({"Gemm", {"w", "x"}, {"y"}, {}}, {w}), {"rows times a constant matrix"});
  expect_error(check({"MatMul", {"x", "x"}, {"y"}, {}}), {"rows times a constant matrix"});
  expect_error(check({"Concat", {"x", "x"}, {"y"}, {whole("axis", 0)}}), {"axis"});
  expect_error(check({"Concat", {"x", "x"}, {"y"}, {}}), {"axis"});
  expect_error(check({"Concat", {"x", "w"}, {"y"}, {whole("axis", 1)}}, {w}), {"expected rows"});
  expect_error(check({"Add", {"x", "w"}, {"y"}, {}}, {w}), {"do not fit"});
  expect_error(check({"Gemm", {"x", "w", "x"}, {"y"}, {}}, {w}), {"bias"});
}

TEST(OnnxCheck, RefusesOperandsThatDoNotFit) {
  expect_error(check({"MatMul", {"x", "w"}, {"y"}, {}}, {constant("w", {4, 3})}),
               {"rows of 3 columns times a matrix of 4x3"});
  expect_error(check({"Gemm", {"x", "w"}, {"y"}, {whole("transB", 2)}}, {constant("w", {3, 3})}),
               {"transB"});
  expect_error(
      check({"Gemm", {"x", "w", "b"}, {"y"}, {}}, {constant("w", {3, 3}), constant("b", {2})}),
      {"bias does not fit 3"});
  expect_error(check({"Add", {"x", "z"}, {"y"}, {}}), {"do not fit"});
  expect_error(check({"Add", {"c", "c"}, {"y"}, {}}, {constant("c", {3})}), {"expected rows"});
  expect_error(check({"Relu", {"c"}, {"y"}, {}}, {constant("c", {3})}), {"expected rows"});
  expect_error(check({"Clip", {"x", "c"}, {"y"}, {}}, {constant("c", {3})}), {"constant numbers"});
  expect_error(check({"Clip", {"x", "z"}, {"y"}, {}}), {"constant numbers"});
  expect_error(check({"Relu", {"x", "x"}, {"y"}, {}}), {"has 2 inputs; expected 1 to 1"});
  expect_error(check({"Add", {"x", ""}, {"y"}, {}}), {"used before it is made"});
  expect_error(check({"Relu", {"x"}, {"y", "u"}, {}}), {"one output"});
}

TEST(OnnxCheck, RefusesAttributesThatTheOperatorDoesNotHave) {
  expect_error(check({"Relu", {"x"}, {"y"}, {whole("axis", 1)}}), {"attribute \"axis\""});
  expect_error(check({"LeakyRelu", {"x"}, {"y"}, {whole("alpha", 1)}}), {"wrong type"});
  expect_error(check({"Concat", {"x"}, {"y"}, {whole("axis", 1), whole("axis", 0)}}),
               {"appears twice"});
}

TEST(OnnxCheck, RefusesGraphsThatAreNoSequence) {
  expect_error(check({"Relu", {"y"}, {"y"}, {}}), {"\"y\" is used before it is made"});
  expect_error(check(graph({{"Relu", {"a"}, {"y"}, {}}, {"Relu", {"x"}, {"a"}, {}}})),
               {"node 0", "\"a\" is used before it is made"});
  expect_error(check(graph({{"Relu", {"x"}, {"y"}, {}}, {"Relu", {"x"}, {"y"}, {}}})),
               {"\"y\" is made twice"});
  expect_error(check({"Relu", {"x"}, {"z"}, {}}), {"\"z\" is made twice"});
  expect_error(check({"Relu", {"x"}, {"y"}, {}}, {constant("x", {3})}), {"\"x\" is made twice"});
  expect_error(check({"Relu", {"x"}, {""}, {}}), {"without a name"});
  expect_error(check({"Relu", {"x"}, {"a"}, {}}), {"no node makes the output \"y\""});
  expect_error(check({"Relu", {"x"}, {"a"}, {}}, {constant("y", {3})}), {"no node makes"});
}

TEST(OnnxCheck, RefusesOtherInputsAndOutputs) {
  const OnnxModel model = graph({{"Relu", {"x"}, {"y"}, {}}});
  const auto against = [&](const Signature& signature) {
    return check_onnx(model, signature, {"scene.glb", "network"});
  };
  EXPECT_TRUE(against({{{"z", 2}, {"x", 3}}, {"y", 3}}));
  expect_error(against({{{"x", 3}}, {"y", 3}}), {"input \"z\" is not expected"});
  expect_error(against({{{"x", 4}, {"z", 2}}, {"y", 3}}), {"\"x\" has 3 columns; expected 4"});
  expect_error(against({{{"x", 3}, {"z", 2}, {"v", 1}}, {"y", 3}}),
               {"expected one input \"v\" of 1 columns; found 0"});
  expect_error(against({{{"x", 3}, {"z", 2}}, {"o", 3}}), {"output \"y\" is not expected"});
  expect_error(against({{{"x", 3}, {"z", 2}}, {"y", 12}}), {"has 3 columns; expected 12"});
  OnnxModel twice = model;
  twice.inputs.push_back({"x", 3});
  expect_error(check(twice), {"expected one input \"x\" of 3 columns; found 2"});
  OnnxModel lies = model;
  lies.outputs[0].count = 4;
  expect_error(check(lies), {"comes out with 3 columns; expected 4"});
}

TEST(OnnxCheck, BoundsTheWork) {
  const Tensor first = constant("w", {3, 1024}), square = constant("q", {1024, 1024});
  std::vector<Node> nodes = {{"MatMul", {"x", "w"}, {"a"}, {}}, {"MatMul", {"a", "q"}, {"y"}, {}}};
  expect_error(check(graph(nodes, {first, square}, 1024)),
               {"node 1", "more than 1048576 multiply-adds"});
  // 16 · 1024 becomes too wide
  expect_error(check(graph({{"MatMul", {"x", "w"}, {"a"}, {}},
                            {"Concat", {"a", "a"}, {"y"}, {whole("axis", 1)}}},
                           {first}, 1024)),
               {"makes 2048 columns; at most 1024"});
}

}  // namespace
}  // namespace fluxgs::networks
