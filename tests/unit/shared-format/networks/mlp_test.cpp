// Plain networks and the models made of them.
#include "fluxgs/networks/mlp.h"

#include <cmath>

#include "networks/onnx_check.h"
#include "tests/unit/shared-format/networks/support.h"

namespace fluxgs::networks {
namespace {

using test::expect_error;

TEST(Mlp, EvaluatesByHand) {
  const Mlp mlp{{{2, 2, {1, 2, -1, 1}, {0.5f, 0}, true}, {2, 1, {3, -2}, {1}, false}}};
  // relu(1·1 + 2·2 + 0.5) = 5.5, relu(−1 + 2) = 1; 3·5.5 − 2·1 + 1 = 15.5
  EXPECT_EQ(evaluate(mlp, std::vector<double>{1, 2}), std::vector<double>{15.5});
  // relu(−3 + 0.5) = 0, relu(3) = 3; −6 + 1 = −5
  EXPECT_EQ(evaluate(mlp, std::vector<double>{-3, 0}), std::vector<double>{-5});
}

TEST(Mlp, EncodesAModelThatTheCheckAccepts) {
  const Signature signature{{{"a", 2}, {"b", 3}}, {"y", 4}};
  const auto bytes = encode_onnx(test::random_mlp({5, 16, 8, 4}, 1), signature);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto model = read_onnx(*bytes, {"m", ""});
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_EQ(model->nodes.size(), 6u);  // Concat, 3 Gemm, 2 Relu
  const auto cost = check_onnx(*model, signature, {"m", ""});
  ASSERT_TRUE(cost) << cost.error().message();
  EXPECT_EQ(cost->work, 5u + 5 * 16 + 16 + 16 * 8 + 8 + 8 * 4);
  EXPECT_EQ(encode_onnx(test::random_mlp({5, 16, 8, 4}, 1), signature), *bytes);
}

TEST(Mlp, RefusesNetworksThatDoNotFit) {
  const Signature signature{{{"x", 2}}, {"y", 1}};
  const Mlp good = test::random_mlp({2, 3, 1}, 1);
  EXPECT_TRUE(encode_onnx(good, signature));
  expect_error(encode_onnx({}, signature), {"no layers"});
  expect_error(encode_onnx(good, {{{"x", 3}}, {"y", 1}}), {"its signature says 3"});
  expect_error(encode_onnx(good, {{}, {"y", 1}}), {"its signature says 0"});
  expect_error(encode_onnx(good, {{{"x", 2}}, {"y", 2}}), {"signature"});
  expect_error(encode_onnx(good, {{{"weights0", 2}}, {"y", 1}}), {"\"weights0\" is made twice"});
  Mlp short_bias = good;
  short_bias.layers[1].bias.clear();
  expect_error(encode_onnx(short_bias, signature), {"layer 1", "not of its size"});
  Mlp gap = good;
  gap.layers[1] = test::random_mlp({4, 1}, 1).layers[0];
  expect_error(encode_onnx(gap, signature), {"layer 1", "outputs of the layer before"});
  Mlp wide = good;
  wide.layers[0].outputs = 5000;
  expect_error(encode_onnx(wide, signature), {"layer 0", "1 to 1024"});
  Mlp nan = good;
  nan.layers[0].weights[2] = std::nanf("");
  expect_error(encode_onnx(nan, signature), {"layer 0", "not finite"});
}

}  // namespace
}  // namespace fluxgs::networks
