// What training may take.
#include "trainer/train/memory_budget.h"

#include <gtest/gtest.h>

#include <limits>

#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

TEST(MemoryBudget, SplatsFillWhatIsAllowed) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(10);
  EXPECT_EQ(splats_in_memory(data, options, 10), std::numeric_limits<std::size_t>::max());
  for (const std::uint64_t mebibytes : {100, 1000, 100000}) {
    options.max_memory = mebibytes;
    const std::size_t most = splats_in_memory(data, options, 10);
    EXPECT_LE(training_memory(data, options, most, 10), mebibytes << 20);
    EXPECT_GT(training_memory(data, options, most + 1, 10), mebibytes << 20);
    EXPECT_LT(splats_in_memory(data, options, 20), most);
  }
}

TEST(MemoryBudget, TooLittleIsAnErrorThatSaysHowMuch) {
  TrainOptions options = short_run(10);
  options.max_memory = 64;
  const auto checked = check_memory(small_capture(), options);
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().message().find("--max-memory: 64 MiB are too few"), std::string::npos)
      << checked.error().message();
  options.max_memory = 100;
  EXPECT_TRUE(check_memory(small_capture(), options));
}

TEST(MemoryBudget, NoSplatsAreAddedBeyondIt) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(100);
  options.get<DensificationOptions>().gradient = 1e-6;
  options.max_splats = 0;
  const std::size_t start = fresh(data, options).parameters.size();
  options.max_memory = (training_memory(data, options, start + 500, kDefaultPairs) >> 20) + 1;
  const std::size_t most = splats_in_memory(data, options, kDefaultPairs);
  const std::size_t bounded = train(data, options, fresh(data, options), 2, 100).parameters.size();
  options.max_memory = 0;
  EXPECT_LE(bounded, std::max(most, start));
  EXPECT_GT(train(data, options, fresh(data, options), 2, 100).parameters.size(), bounded);
}

}  // namespace
}  // namespace fluxgs
