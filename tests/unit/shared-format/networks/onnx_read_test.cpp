// Reading the ONNX format: what a scene's network may consist of, and everything else refused.
#include <limits>
#include <random>

#include <fmt/format.h>

#include "networks/onnx_check.h"
#include "tests/unit/shared-format/networks/support.h"

namespace fluxgs::networks {
namespace {

using test::Bytes, test::RawModel, test::expect_error, test::floats, test::integer, test::message,
    test::text;
using test::operator+;  // NOLINT(misc-unused-using-decls): it is used

const Place kPlace{"scene.glb", "network psi"};

Expected<RowCost> open(const Bytes& bytes, const Signature& signature = test::kRawSignature) {
  const auto model = read_onnx(bytes, kPlace);
  if (!model) return std::unexpected(model.error());
  return check_onnx(*model, signature, kPlace);
}

void refuses(const RawModel& raw, std::vector<std::string> parts) {
  parts.insert(parts.begin(), "scene.glb: network psi");
  expect_error(open(raw.bytes()), parts);
}

TEST(OnnxRead, ReadsAModelWrittenFieldByField) {
  const auto model = read_onnx(RawModel().bytes(), kPlace);
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->opset, 17);
  EXPECT_EQ(model->ir_version, 8);
  ASSERT_EQ(model->nodes.size(), 1u);
  EXPECT_EQ(model->nodes[0].op, "Gemm");
  EXPECT_EQ(model->nodes[0].inputs, (std::vector<std::string>{"x", "w"}));
  ASSERT_EQ(model->tensors.size(), 1u);
  EXPECT_EQ(model->tensors[0].dims, (std::vector<std::int64_t>{2, 3}));
  EXPECT_EQ(model->tensors[0].values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  const auto cost = check_onnx(*model, test::kRawSignature, kPlace);
  ASSERT_TRUE(cost) << cost.error().message();
  EXPECT_EQ(cost->work, 6u);
  EXPECT_EQ(cost->columns, 5u);
}

TEST(OnnxRead, AcceptsTheOtherWaysToWriteTheSame) {
  RawModel packed;
  packed.dims = message(1, Bytes{std::byte{2}, std::byte{3}});
  packed.values = floats(4, std::vector<float>{1, 2, 3, 4, 5, 6});
  packed.rows = integer(1, -1);
  packed.opset = text(1, "ai.onnx") + integer(2, 21);
  packed.model = text(2, "another program") + text(6, "about") + message(14, text(1, "key"));
  packed.graph = text(10, "about") + message(13, text(1, "x"));
  packed.tensor = integer(14, 0) + text(12, "about");
  const auto cost = open(packed.bytes());
  EXPECT_TRUE(cost) << cost.error().message();
  RawModel unnamed;
  unnamed.rows = {};
  EXPECT_TRUE(open(unnamed.bytes()));
}

TEST(OnnxRead, WritesWhatItRead) {
  const auto model = read_onnx(RawModel().bytes(), kPlace);
  ASSERT_TRUE(model);
  const Bytes once = write_onnx(*model);
  const auto again = read_onnx(once, kPlace);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(write_onnx(*again), once);
}

TEST(OnnxRead, RefusesExternalData) {
  RawModel named;
  named.tensor = message(13, text(1, "location") + text(2, "/etc/passwd"));
  refuses(named, {"initializer 0", "external_data", "not accepted"});
  RawModel located;
  located.tensor = integer(14, 1);
  refuses(located, {"initializer 0", "data_location", "external data is not accepted"});
}

TEST(OnnxRead, RefusesWhatIsMoreThanAGraph) {
  const std::pair<std::uint32_t, const char*> model_fields[] = {
      {20, "training_info"}, {25, "functions"}, {26, "configuration"}};
  for (const auto& [number, name] : model_fields) {
    RawModel raw;
    raw.model = message(number, {});
    refuses(raw, {name, "not accepted"});
  }
  for (const auto& [number, name] :
       {std::pair{14u, "quantization_annotation"}, std::pair{15u, "sparse_initializer"}}) {
    RawModel raw;
    raw.graph = message(number, {});
    refuses(raw, {"graph", name, "not accepted"});
  }
  RawModel domain;
  domain.opset = text(1, "com.microsoft") + integer(2, 1);
  refuses(domain, {"opset_import", "com.microsoft"});
  RawModel second;
  second.model = message(8, text(1, "com.microsoft") + integer(2, 1));
  refuses(second, {"opset_import", "appears twice"});
  RawModel node_domain;
  node_domain.node = node_domain.node + text(7, "com.microsoft");
  refuses(node_domain, {"node 0", "domain", "com.microsoft"});
}

TEST(OnnxRead, RefusesSubGraphsAndOtherAttributes) {
  for (const std::uint32_t number : {4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 14u, 15u, 21u, 22u, 23u}) {
    RawModel raw;
    raw.attribute = text(1, "body") + message(number, {});
    refuses(raw, {"node 0", "attribute", "not accepted"});
  }
  RawModel graph;
  graph.attribute = text(1, "body") + message(6, {}) + integer(20, 5);
  refuses(graph, {"sub-graph"});
  RawModel untyped;
  untyped.attribute = text(1, "transB") + integer(3, 1);
  refuses(untyped, {"transB", "type 0"});
}

TEST(OnnxRead, RefusesOtherTypesAndShapes) {
  RawModel doubles;
  doubles.element = integer(2, 11);
  refuses(doubles, {"\"w\"", "element type 11", "float32"});
  RawModel input;
  input.input_element = integer(1, 10);
  refuses(input, {"input", "element type 10", "float32"});
  RawModel fixed;
  fixed.rows = integer(1, 5);
  refuses(fixed, {"\"x\"", "free number of rows"});
  RawModel open_columns;
  open_columns.columns = text(2, "C");
  refuses(open_columns, {"\"x\"", "known number of columns"});
  RawModel wide;
  wide.columns = integer(1, 2000);
  refuses(wide, {"is 2000; expected 1 to 1024"});
  RawModel rank;
  rank.dims = integer(1, 1) + integer(1, 2) + integer(1, 3);
  refuses(rank, {"dims", "more than 2"});
  for (const std::int64_t dim : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1025},
                                 std::numeric_limits<std::int64_t>::max()}) {
    RawModel raw;
    raw.dims = integer(1, dim) + integer(1, 3);
    refuses(raw, {"dims", "expected 1 to 1024"});
  }
  RawModel sequence;
  sequence.value = message(2, message(4, {}));
  refuses(sequence, {"type", "appears twice"});
}

TEST(OnnxRead, RefusesValuesThatDoNotFitOrAreNotFinite) {
  RawModel few;
  few.values = floats(9, std::vector<float>{1, 2, 3});
  refuses(few, {"\"w\"", "12 bytes for 6 values"});
  RawModel none;
  none.values = {};
  refuses(none, {"raw_data or float_data"});
  RawModel both;
  both.tensor = floats(4, std::vector<float>{1, 2, 3, 4, 5, 6});
  refuses(both, {"raw_data or float_data"});
  RawModel huge;  // 4 MiB promised
  huge.dims = integer(1, 1024) + integer(1, 1024);
  refuses(huge, {"24 bytes for 1048576 values"});
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    RawModel raw;
    raw.values = floats(9, std::vector<float>{1, 2, 3, bad, 5, 6});
    refuses(raw, {"value 3 is not finite"});
  }
}

TEST(OnnxRead, RefusesVersionsOutOfRange) {
  for (const std::int64_t opset :
       {std::int64_t{0}, std::int64_t{12}, std::int64_t{22}, std::int64_t{-1}}) {
    RawModel raw;
    raw.opset = integer(2, opset);
    refuses(raw, {"opset_import", "expected 13 to 21"});
  }
  RawModel ir;
  ir.ir_version = integer(1, 11);
  refuses(ir, {"ir_version", "is 11; expected 3 to 10"});
  expect_error(open({}), {"ir_version"});
}

TEST(OnnxRead, RefusesTooMuch) {
  RawModel nodes;
  for (int i = 0; i < 64; ++i) nodes.graph = nodes.graph + message(1, nodes.node);
  refuses(nodes, {"node", "more than 64"});
  RawModel tensors;
  const Bytes one = integer(2, 1) + floats(9, std::vector<float>{1});
  for (int i = 0; i < 128; ++i) {
    tensors.graph = tensors.graph + message(5, one + text(8, fmt::format("t{}", i)));
  }
  refuses(tensors, {"initializer", "more than 128"});
  RawModel operands;
  for (int i = 0; i < 15; ++i) operands.node = operands.node + text(1, "x");
  refuses(operands, {"node 0", "input", "more than 16"});
  RawModel big;
  big.model = text(6, std::string(kMaxModelBytes, ' '));
  refuses(big, {"at most 4194304 are accepted"});
  RawModel name;
  name.node = text(1, std::string(300, 'x')) + text(4, "Relu");
  refuses(name, {"node 0", "at most 256 characters"});
  RawModel control;
  control.node = text(1, "x\n\x1b[31m") + text(4, "Relu");
  refuses(control, {"printable ASCII"});
}

TEST(OnnxRead, RefusesWhatTwoReadersCouldReadInTwoWays) {
  RawModel unknown;
  unknown.model = integer(99, 1);
  refuses(unknown, {"field 99"});
  RawModel wrong_type;
  wrong_type.model = integer(7, 1);
  refuses(wrong_type, {"field 7 of wire type 0"});
  const Bytes valid = RawModel().bytes();
  expect_error(open(valid + valid), {"ir_version", "appears twice"});
  RawModel graph;
  graph.model = message(7, {});
  refuses(graph, {"graph", "appears twice"});
  RawModel group;
  group.model = Bytes{std::byte{0x0b}};
  refuses(group, {"not a Protocol Buffers message"});
  RawModel overlong;
  overlong.model = Bytes(11, std::byte{0xff});
  refuses(overlong, {"not a Protocol Buffers message"});
}

TEST(OnnxRead, EveryTruncationIsRefused) {
  const Bytes bytes = RawModel().bytes();
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_FALSE(open(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)))) << n;
  }
}

// Nothing here can be asserted but that every answer is an answer; sanitizers watch.
TEST(OnnxRead, DamagedModelsGiveAnAnswer) {
  const auto valid = encode_onnx(test::random_mlp({5, 8, 3}, 1), {{{"a", 2}, {"b", 3}}, {"y", 3}});
  ASSERT_TRUE(valid) << valid.error().message();
  std::mt19937 random(7);
  std::size_t refused = 0;
  constexpr std::size_t kTries = 30000;
  for (std::size_t i = 0; i < kTries; ++i) {
    Bytes bytes = *valid;
    for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
      std::byte& b = bytes[random() % bytes.size()];
      b = random() % 2 == 0 ? b ^ std::byte(1 << random() % 8) : std::byte(random());
    }
    refused += !open(bytes, {{{"a", 2}, {"b", 3}}, {"y", 3}});
  }
  // Most bytes are weights, whose damage is not seen unless they become infinite
  EXPECT_GT(refused, kTries / 10);
  EXPECT_LT(refused, kTries);
}

}  // namespace
}  // namespace fluxgs::networks
