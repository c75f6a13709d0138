// The networks' training: products, values and derivatives against float64, Adam, checkpoints.
#include "trainer/paper/trainable_mlp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace fluxgs {
namespace {

const std::vector<std::vector<int>> kShapes = {
    {23, 128, 64, 32, 12}, {15, 64, 12}, {5, 17, 3}, {4, 3}};

void fill(PlanarFloats& m, Random& random) {
  for (int r = 0; r < m.rows(); ++r)
    for (std::size_t c = 0; c < m.size(); ++c) m.row(r)[c] = static_cast<float>(normal(random));
}

std::vector<double> row_of(const PlanarFloats& m, int r) { return {m.row(r), m.row(r) + m.size()}; }

/// A batch of random inputs, evaluated.
struct Evaluated {
  TrainableMlp mlp;
  MlpBatch batch;
  PlanarFloats outputs;
  Evaluated(const std::vector<int>& sizes, std::size_t begin, std::size_t end, Isa isa) {
    Random random(7);
    mlp = make_mlp(sizes, false, random);
    reserve(batch, mlp, end);
    fill(batch.values[0], random);
    outputs = PlanarFloats(kMlpPiece, static_cast<std::size_t>(sizes.back()));
    forward(mlp, batch, begin, end, outputs, mlp_kernels(isa));
  }
};

class Mlp : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, Mlp, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

TEST_P(Mlp, ProductsAreThoseOfTheirDefinition) {
  Random random(3);
  for (const int rows : {1, 5, 6, 23, 96})
    for (const int columns : {3, 16, 32, 48, 64, 112, 128}) {
      const int depth = 1 + rows % 7 * 9;
      const auto width = static_cast<std::size_t>(columns);
      PlanarFloats a(rows, static_cast<std::size_t>(depth)), b(depth, width), extra(rows, width);
      for (PlanarFloats* m : {&a, &b, &extra}) fill(*m, random);
      for (const MlpEpilogue epilogue : {MlpEpilogue::bias, MlpEpilogue::bias_relu,
                                         MlpEpilogue::mask, MlpEpilogue::store, MlpEpilogue::add}) {
        PlanarFloats c = extra;
        mlp_kernels(GetParam())
            .product({a.data(), a.stride(), 1, b.data(), b.stride(), c.data(), c.stride(),
                      static_cast<std::size_t>(rows), b.stride(), static_cast<std::size_t>(depth),
                      epilogue, extra.data()});
        for (int r = 0; r < rows; ++r)
          for (std::size_t j = 0; j < width; ++j) {
            double sum = 0;
            for (int k = 0; k < depth; ++k) sum += double{a.row(r)[k]} * double{b.row(k)[j]};
            const double own = extra.row(r)[j], bias = extra.row(0)[j];
            const double expected = epilogue == MlpEpilogue::bias        ? sum + bias
                                    : epilogue == MlpEpilogue::bias_relu ? std::max(0.0, sum + bias)
                                    : epilogue == MlpEpilogue::mask      ? (own > 0 ? sum : 0)
                                    : epilogue == MlpEpilogue::add       ? sum + own
                                                                         : sum;
            ASSERT_NEAR(c.row(r)[j], expected, 1e-5 * (1 + std::sqrt(depth)))
                << rows << "x" << columns << ", epilogue " << static_cast<int>(epilogue);
          }
      }
    }
}

TEST_P(Mlp, EvaluatesAsInFloat64) {
  for (const auto& sizes : kShapes)
    for (const auto& [begin, end] : {std::pair(0, 96), std::pair(0, 1), std::pair(10, 53)}) {
      const Evaluated e(sizes, static_cast<std::size_t>(begin), static_cast<std::size_t>(end),
                        GetParam());
      const networks::Mlp mlp = to_mlp(e.mlp);
      ASSERT_TRUE(networks::check_mlp(mlp));
      for (int r = begin; r < end; ++r) {
        const auto expected = networks::evaluate(mlp, row_of(e.batch.values[0], r));
        for (std::size_t k = 0; k < expected.size(); ++k)
          ASSERT_NEAR(e.outputs.row(r - begin)[k], expected[k], 3e-6) << sizes.size();
      }
    }
}

/// L = Σ of weight · output over rows [begin, end), in float64.
double loss(const networks::Mlp& mlp, const PlanarFloats& inputs, const PlanarFloats& weights,
            int begin, int end) {
  double sum = 0;
  for (int r = begin; r < end; ++r) {
    const auto out = networks::evaluate(mlp, row_of(inputs, r));
    for (std::size_t k = 0; k < out.size(); ++k) sum += out[k] * double{weights.row(r - begin)[k]};
  }
  return sum;
}

TEST_P(Mlp, GradientsAreThoseOfCentralDifferences) {
  constexpr int kBegin = 4, kEnd = 25;
  constexpr float kStep = 1e-4f;
  for (const auto& sizes : kShapes) {
    Evaluated e(sizes, kBegin, kEnd, GetParam());
    Random random(9);
    PlanarFloats delta(kMlpPiece, static_cast<std::size_t>(sizes.back()));
    fill(delta, random);
    MlpTransposed transposed;
    const int first = sizes[0] / 3, wanted = sizes[0] - first;
    transpose(e.mlp, first, wanted, transposed);
    MlpMatrices gradient = make_matrices(sizes);
    for (PlanarFloats& g : gradient) g.row(0)[0] = 5;  // is added to
    PlanarFloats inputs(kMlpPiece, static_cast<std::size_t>(wanted));
    backward(e.mlp, transposed, e.batch, kBegin, kEnd, delta, gradient, inputs,
             mlp_kernels(GetParam()));
    for (PlanarFloats& g : gradient) g.row(0)[0] -= 5;

    const auto slope = [&](float& value) {
      const float own = value;
      const auto at = [&](float v) {
        value = v;
        return loss(to_mlp(e.mlp), e.batch.values[0], delta, kBegin, kEnd);
      };
      const float up = own + kStep, down = own - kStep;
      const double result = (at(up) - at(down)) / (double{up} - double{down});
      value = own;
      return result;
    };
    for (std::size_t l = 0; l < e.mlp.layers(); ++l)
      for (int n = 0; n < 12; ++n) {
        PlanarFloats& w = e.mlp.weights[l];
        const int r = n < 3 ? w.rows() - 1 : static_cast<int>(uniform(random) * w.rows());
        const auto c = static_cast<std::size_t>(uniform(random) * static_cast<double>(w.size()));
        ASSERT_NEAR(gradient[l].row(r)[c], slope(w.row(r)[c]), 2e-3) << "layer " << l;
      }
    for (int n = 0; n < 12; ++n) {
      const int r = kBegin + static_cast<int>(uniform(random) * (kEnd - kBegin));
      const int c = static_cast<int>(uniform(random) * wanted);
      ASSERT_NEAR(inputs.row(r - kBegin)[c], slope(e.batch.values[0].row(r)[first + c]), 2e-3);
    }
  }
}

// Only x86-64's baseline has no fused multiply-add
TEST(Mlp, TheLanesOfAnInstructionSetDoNotChangeABit) {
  const std::vector<Isa> isas = available_isas();
  if (isas.size() < 3) GTEST_SKIP() << "needs AVX2 and AVX-512";
  const Evaluated a(kShapes[0], 0, 96, Isa::avx2), b(kShapes[0], 0, 96, Isa::avx512);
  EXPECT_EQ(std::memcmp(a.outputs.data(), b.outputs.data(), kMlpPiece * 16 * sizeof(float)), 0);
}

TEST(Mlp, BeginsAsPyTorchDoes) {
  Random random(1), same(1);
  const TrainableMlp mlp = make_mlp({100, 300, 20}, true, random);
  double largest = 0, squares = 0;
  const PlanarFloats& w = mlp.weights[0];
  for (int r = 0; r < w.rows(); ++r)
    for (std::size_t c = 0; c < w.size(); ++c) {
      const double v = w.row(r)[c];
      largest = std::max(largest, std::abs(v));
      squares += v * v;
    }
  EXPECT_LE(largest, 0.1);
  EXPECT_GT(largest, 0.099);
  EXPECT_NEAR(squares / (101 * 300), 0.01 / 3, 1e-4);  // uniform in ±0.1
  EXPECT_EQ(mlp.weights[0].row(0)[300], 0);            // padding
  for (int r = 0; r < 301; ++r)
    for (std::size_t c = 0; c < 20; ++c) ASSERT_EQ(mlp.weights[1].row(r)[c], 0);
  EXPECT_EQ(to_floats(mlp), to_floats(make_mlp({100, 300, 20}, true, same)));
}

TEST_P(Mlp, AdamFollowsItsDefinitionAndSkipsWhatIsNotFinite) {
  Random random(2);
  TrainableMlp mlp = make_mlp({6, 9, 2}, false, random);
  const TrainableMlp start = mlp;
  const AdamConstants constants{0.9, 0.999, 1e-15};
  std::vector<MlpMatrices> gradients;
  std::uint64_t rejected = 0;
  for (int step = 0; step < 6; ++step) {
    gradients.push_back(make_matrices(mlp.sizes));
    for (PlanarFloats& g : gradients.back()) fill(g, random);
    if (step == 2) gradients.back()[0].row(1)[3] = std::nanf("");
    if (step == 4) gradients.back()[1].row(9)[1] = -std::numeric_limits<float>::infinity();
    rejected +=
        adam_step(mlp, gradients.back(), 0.01 * (step + 1), constants, adam_kernels(GetParam()));
  }
  EXPECT_EQ(rejected, 2u);
  EXPECT_EQ(mlp.steps, 6);
  for (std::size_t l = 0; l < 2; ++l)
    for (int r = 0; r < mlp.weights[l].rows(); ++r)
      for (std::size_t c = 0; c < mlp.weights[l].size(); ++c) {
        double x = start.weights[l].row(r)[c], m = 0, v = 0;
        for (int step = 1; step <= 6; ++step) {
          const double g = gradients[static_cast<std::size_t>(step - 1)][l].row(r)[c];
          if (!std::isfinite(g)) continue;
          m = 0.9 * m + 0.1 * g;
          v = 0.999 * v + 0.001 * g * g;
          x -= 0.01 * step * (m / (1 - std::pow(0.9, step))) /
               (std::sqrt(v / (1 - std::pow(0.999, step))) + 1e-15);
        }
        ASSERT_NEAR(mlp.weights[l].row(r)[c], x, 2e-5) << l << ' ' << r << ' ' << c;
      }
  EXPECT_EQ(mlp.weights[0].row(0)[9], 0);  // padding
}

TEST(Mlp, GoesThroughAListOfFloats) {
  Random random(2);
  TrainableMlp mlp = make_mlp({6, 9, 2}, false, random);
  MlpMatrices gradient = make_matrices(mlp.sizes);
  for (PlanarFloats& g : gradient) fill(g, random);
  for (int step = 0; step < 3; ++step)
    adam_step(mlp, gradient, 0.01, {0.9, 0.999, 1e-15}, adam_kernels(best_isa()));
  mlp.steps = (1 << 24) + 1;  // not a float
  const std::vector<float> floats = to_floats(mlp);
  EXPECT_EQ(floats.size(), float_count(mlp.sizes));
  const auto again = mlp_from_floats(mlp.sizes, floats);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->steps, mlp.steps);
  EXPECT_EQ(to_floats(*again), floats);
  EXPECT_EQ(again->second[1].row(9)[1], mlp.second[1].row(9)[1]);

  const auto shorter = mlp_from_floats(mlp.sizes, std::span(floats).first(floats.size() - 1));
  ASSERT_FALSE(shorter);
  EXPECT_EQ(shorter.error().message(), "network: 250 values, expected 251");
  std::vector<float> bad = floats;
  for (const float steps : {-1.0f, 1e20f, std::nanf("")}) {
    bad[0] = steps;
    EXPECT_FALSE(mlp_from_floats(mlp.sizes, bad));
  }
}

}  // namespace
}  // namespace fluxgs
