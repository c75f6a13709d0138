// Running networks with onnxruntime, and finding that library.
#include "networks/onnx_network.h"

#include <dlfcn.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "networks/flush_denormals.h"
#include "tests/unit/shared-format/networks/support.h"

#if __has_include(<onnxruntime_c_api.h>)
#include <onnxruntime_c_api.h>
#define HAS_OFFICIAL_HEADER 1
#endif

namespace fluxgs::networks {
namespace {

using test::Bytes, test::expect_error;

const Place kPlace{"scene.glb", "network"};

/// Sets a variable and puts it back.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value, 1);
  }
  ~Variable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

struct Worst {
  double error = 0, largest = 0;  // |float32 − float64|, |float64|
};

/// The network of onnxruntime against the float64 evaluation, over `rows` rows with one input.
Worst worst_error(const Mlp& mlp, std::size_t rows) {
  const auto columns = static_cast<std::size_t>(mlp.layers.front().inputs);
  const auto outputs = static_cast<std::size_t>(mlp.layers.back().outputs);
  const Signature signature{{{"x", static_cast<int>(columns)}}, {"y", static_cast<int>(outputs)}};
  const auto bytes = encode_onnx(mlp, signature);
  EXPECT_TRUE(bytes) << bytes.error().message();
  auto network = OnnxNetwork::load(*bytes, signature, kPlace);
  EXPECT_TRUE(network) << network.error().message();
  const std::vector<float> input = test::random_rows(rows * columns, 5);
  std::vector<float> output(rows * outputs);
  const std::span<const float> views[] = {input};
  const auto ran = network->run(rows, views, output);
  EXPECT_TRUE(ran) << ran.error().message();
  Worst worst;
  for (std::size_t r = 0; r < rows; ++r) {
    const auto* begin = input.data() + r * columns;
    const auto exact = evaluate(mlp, std::vector<double>(begin, begin + columns));
    for (std::size_t k = 0; k < outputs; ++k) {
      worst.error = std::max(worst.error, std::fabs(double{output[r * outputs + k]} - exact[k]));
      worst.largest = std::max(worst.largest, std::fabs(exact[k]));
    }
  }
  return worst;
}

TEST(OnnxNetwork, AgreesWithFloat64) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  for (const std::vector<int>& sizes : {std::vector{15, 64, 12}, std::vector{23, 128, 64, 32, 12},
                                        std::vector{1, 1}, std::vector{3, 1024, 7}}) {
    const Worst worst = worst_error(test::random_mlp(sizes, 3), 1000);
    RecordProperty("worst_" + std::to_string(sizes.front()), std::to_string(worst.error));
    // Rounding of sums of up to 1024 products
    EXPECT_LT(worst.error, 1e-6 * std::max(worst.largest, 1.0) * 4);
    EXPECT_GT(worst.largest, 0.1);
  }
}

TEST(OnnxNetwork, ResultsDoNotDependOnTheBatch) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const Signature signature{{{"x", 23}}, {"y", 12}};
  const auto bytes = encode_onnx(test::random_mlp({23, 128, 64, 32, 12}, 4), signature);
  auto network = OnnxNetwork::load(*bytes, signature, kPlace);
  ASSERT_TRUE(network) << network.error().message();
  EXPECT_EQ(network->batch(), kMaxBatch);
  const std::vector<float> input = test::random_rows(1000 * 23, 6);
  std::vector<float> all(1000 * 12), part(12);
  const std::span<const float> views[] = {input};
  ASSERT_TRUE(network->run(1000, views, all));
  for (const std::size_t row : {std::size_t{0}, std::size_t{17}, std::size_t{999}}) {
    const std::span<const float> one[] = {std::span(input).subspan(row * 23, 23)};
    ASSERT_TRUE(network->run(1, one, part));
    for (std::size_t k = 0; k < 12; ++k) EXPECT_NEAR(part[k], all[row * 12 + k], 1e-5f);
  }
  EXPECT_TRUE(network->run(0, std::vector<std::span<const float>>(1), {}));
}

TEST(OnnxNetwork, RunsEveryOperator) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  OnnxModel model;
  model.inputs = {{"x", 2}, {"z", 1}};
  model.outputs = {{"y", 3}};
  model.tensors = {{"w", {3, 2}, {1, 2, 3, 4, 5, 6}},
                   {"half", {}, {0.5f}},
                   {"low", {}, {-1}},
                   {"v", {2, 2}, {1, 0, 0, 2}}};
  const auto one = std::int64_t{1};
  model.nodes = {{"Concat", {"x", "z"}, {"a"}, {{"axis", std::int64_t{-1}}}},
                 {"MatMul", {"a", "w"}, {"b"}, {}},
                 {"Gemm", {"b", "v", "half"}, {"c"}, {{"alpha", 2.0f}, {"transB", one}}},
                 {"Sub", {"c", "z"}, {"d"}, {}},
                 {"Mul", {"d", "half"}, {"e"}, {}},
                 {"Div", {"e", "half"}, {"f"}, {}},
                 {"LeakyRelu", {"f"}, {"g"}, {{"alpha", 0.25f}}},
                 {"Clip", {"g", "low", ""}, {"h"}, {}},
                 {"Identity", {"h"}, {"i"}, {}},
                 {"Tanh", {"z"}, {"j"}, {}},
                 {"Sigmoid", {"j"}, {"k"}, {}},
                 {"Add", {"k", "j"}, {"l"}, {}},
                 {"Concat", {"i", "l"}, {"m"}, {{"axis", one}}},
                 {"Relu", {"m"}, {"y"}, {}}};
  for (const std::int64_t opset : {kMinOpset, std::int64_t{17}, kMaxOpset}) {
    model.opset = opset;
    auto network = OnnxNetwork::load(write_onnx(model), {model.inputs, model.outputs[0]}, kPlace);
    ASSERT_TRUE(network) << network.error().message();
    const std::vector<float> x = {1, -2, 0.5f, 0}, z = {0.5f, -1};
    std::vector<float> y(6);
    const std::span<const float> views[] = {x, z};
    const auto ran = network->run(2, views, y);
    ASSERT_TRUE(ran) << ran.error().message();
    // Row 0: a = (1, −2, 0.5), b = (−2.5, −3), c = 2·(−2.5, −6) + 0.5 = (−4.5, −11.5),
    // d = (−5, −12) → LeakyRelu (−1.25, −3) → Clip (−1, −1) → Relu 0.
    // Row 1: a = (0.5, 0, −1), b = (−4.5, −5), c = (−8.5, −19.5), d = (−7.5, −18.5) → 0 as well.
    const auto last = [](double v) {
      const double t = std::tanh(v);
      return std::max(0.0, 1 / (1 + std::exp(-t)) + t);
    };
    EXPECT_EQ(y[0], 0);
    EXPECT_EQ(y[1], 0);
    EXPECT_NEAR(y[2], last(0.5), 1e-6);
    EXPECT_EQ(y[3], 0);
    EXPECT_EQ(y[4], 0);
    EXPECT_NEAR(y[5], last(-1), 1e-6);
    const std::vector<float> other = {1, 1, 0, 0};  // b = (4 + 5z, 6 + 6z)
    const std::span<const float> positive[] = {other, z};
    ASSERT_TRUE(network->run(2, positive, y));
    EXPECT_NEAR(y[0], 2 * 6.5 + 0.5 - 0.5, 1e-5);
    EXPECT_NEAR(y[1], 4 * 9 + 0.5 - 0.5, 1e-5);
  }
}

TEST(OnnxNetwork, RefusesResultsThatAreNotFinite) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const Signature signature{{{"x", 1}}, {"y", 2}};
  const Mlp mlp{{{1, 2, {1, 3e38f}, {0, 0}, false}}};
  auto network = OnnxNetwork::load(*encode_onnx(mlp, signature), signature, kPlace);
  ASSERT_TRUE(network) << network.error().message();
  std::vector<float> output(4);
  const std::vector<float> input = {1, 2};
  const std::span<const float> views[] = {input};
  expect_error(network->run(2, views, output), {"scene.glb: network", "column 1 is not finite"});
}

TEST(OnnxNetwork, RefusesInputsOfTheWrongSizeAndTooMuchWork) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const Signature signature{{{"x", 1}}, {"y", 1}};
  auto network = OnnxNetwork::load(*encode_onnx(test::random_mlp({1, 1024, 1}, 1), signature),
                                   signature, kPlace);
  ASSERT_TRUE(network) << network.error().message();
  EXPECT_EQ(network->batch(), (std::size_t{16} << 20) / 4 / 2050);
  std::vector<float> values(10);
  const std::span<const float> views[] = {values};
  expect_error(network->run(9, views, values), {"not of the size of its rows"});
  expect_error(network->run(10, {}, values), {"not of the size of its rows"});
  EXPECT_TRUE(network->check_rows(10'000'000));
  expect_error(network->check_rows(std::size_t{1} << 27), {"multiply-adds", "are accepted"});
}

// What gets past the check must be what onnxruntime can run, whatever it was made of.
TEST(OnnxNetwork, DamagedModelsThatPassTheCheckRun) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  const Signature signature{{{"a", 2}, {"b", 1}}, {"y", 2}};
  const Bytes valid = *encode_onnx(test::random_mlp({3, 2, 2}, 1), signature);
  const std::vector<float> input = test::random_rows(10, 1);
  const std::span<const float> views[] = {std::span(input).first(10), std::span(input).first(5)};
  std::vector<float> output(10);
  int ran = 0;
  for (std::size_t i = 0; i < valid.size(); ++i) {
    for (int bit = 0; bit < 8; bit += 3) {
      Bytes bytes = valid;
      bytes[i] ^= std::byte(1 << bit);
      auto network = OnnxNetwork::load(bytes, signature, kPlace);
      if (!network) {
        EXPECT_EQ(network.error().message().find("onnxruntime"), std::string::npos)
            << network.error().message();
        continue;
      }
      const auto done = network->run(5, views, output);
      EXPECT_TRUE(done || done.error().message().find("not finite") != std::string::npos)
          << done.error().message();
      ++ran;
    }
  }
  EXPECT_GT(ran, 20);
}

TEST(FlushDenormals, HoldsForItsLifeOnly) {
  const volatile float least = std::numeric_limits<float>::min(), half = 0.5f;
  const auto product = [&] { return least * half; };
  EXPECT_GT(product(), 0);
  {
    const FlushDenormals flush;
    EXPECT_EQ(product(), 0);
  }
  EXPECT_GT(product(), 0);
}

TEST(OnnxRuntime, IsNotNeededToRefuseAModel) {
  if (test::onnxruntime_is_loaded()) GTEST_SKIP() << "loaded by another test of this process";
  EXPECT_FALSE(OnnxNetwork::load(Bytes(10), {{{"x", 1}}, {"y", 1}}, kPlace));
  EXPECT_FALSE(test::onnxruntime_is_loaded());
}

TEST(OnnxRuntime, MissingLibraryIsOneLine) {
  if (test::onnxruntime_is_loaded()) GTEST_SKIP() << "loaded by another test of this process";
  const Signature signature{{{"x", 1}}, {"y", 1}};
  const Bytes model = *encode_onnx(test::random_mlp({1, 1}, 1), signature);
  {
    const Variable named("FLUXGS_ONNXRUNTIME", "/nowhere/libonnxruntime.so");
    expect_error(OnnxNetwork::load(model, signature, kPlace),
                 {"/nowhere/libonnxruntime.so", "cannot be loaded", "run tools/setup",
                  "FLUXGS_ONNXRUNTIME"});
  }
  {
    const Variable other("FLUXGS_ONNXRUNTIME", "libm.so.6");
    expect_error(onnx_runtime_info(), {"libm.so.6", "is not onnxruntime", "run tools/setup"});
  }
  FLUXGS_NEEDS_ONNXRUNTIME();  // a later call tries again
}

TEST(OnnxRuntime, TelemetryIsOffBeforeTheLibraryStarts) {
  FLUXGS_NEEDS_ONNXRUNTIME();
  EXPECT_STREQ(std::getenv("ORT_DISABLE_TELEMETRY"), "1");
  EXPECT_TRUE(test::onnxruntime_is_loaded());
}

#ifdef HAS_OFFICIAL_HEADER
#define EXPECT_SLOT(mine, theirs) EXPECT_EQ(slots.mine * sizeof(void*), offsetof(OrtApi, theirs))

TEST(OnnxRuntime, DeclarationsMatchTheOfficialHeader) {
  constexpr ort::Slots slots;
  EXPECT_SLOT(error_message, GetErrorMessage);
  EXPECT_SLOT(create_env, CreateEnv);
  EXPECT_SLOT(disable_telemetry, DisableTelemetryEvents);
  EXPECT_SLOT(create_session, CreateSessionFromArray);
  EXPECT_SLOT(run, Run);
  EXPECT_SLOT(create_options, CreateSessionOptions);
  EXPECT_SLOT(disable_memory_pattern, DisableMemPattern);
  EXPECT_SLOT(disable_arena, DisableCpuMemArena);
  EXPECT_SLOT(set_optimization, SetSessionGraphOptimizationLevel);
  EXPECT_SLOT(set_threads, SetIntraOpNumThreads);
  EXPECT_SLOT(wrap_tensor, CreateTensorWithDataAsOrtValue);
  EXPECT_SLOT(tensor_data, GetTensorMutableData);
  EXPECT_SLOT(element_type, GetTensorElementType);
  EXPECT_SLOT(rank, GetDimensionsCount);
  EXPECT_SLOT(dimensions, GetDimensions);
  EXPECT_SLOT(shape_of, GetTensorTypeAndShape);
  EXPECT_SLOT(create_memory_info, CreateCpuMemoryInfo);
  EXPECT_SLOT(add_config, AddSessionConfigEntry);
  EXPECT_SLOT(release_status, ReleaseStatus);
  EXPECT_SLOT(release_memory_info, ReleaseMemoryInfo);
  EXPECT_SLOT(release_session, ReleaseSession);
  EXPECT_SLOT(release_value, ReleaseValue);
  EXPECT_SLOT(release_shape, ReleaseTensorTypeAndShapeInfo);
  EXPECT_SLOT(release_options, ReleaseSessionOptions);
  EXPECT_EQ(offsetof(ort::ApiBase, get_api), offsetof(OrtApiBase, GetApi));
  EXPECT_EQ(offsetof(ort::ApiBase, get_version), offsetof(OrtApiBase, GetVersionString));
  EXPECT_EQ(ort::kLogFatal, ORT_LOGGING_LEVEL_FATAL);
  EXPECT_EQ(ort::kOptimizeAll, ORT_ENABLE_ALL);
  EXPECT_EQ(ort::kDeviceAllocator, OrtDeviceAllocator);
  EXPECT_EQ(ort::kDefaultMemory, OrtMemTypeDefault);
  EXPECT_EQ(ort::kFloat, ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT);
  EXPECT_EQ(sizeof(ONNXTensorElementDataType), sizeof(int));
  EXPECT_GE(ORT_API_VERSION, ort::kApiVersion);
}
#endif

}  // namespace
}  // namespace fluxgs::networks
