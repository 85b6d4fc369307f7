// SPDX-License-Identifier: BSD-2-Clause
// The estimator keeps what it promises for observations and IMU intervals of any content.
// FACET_FUZZ_RUNS sets how many; `make test-long` runs the same under libFuzzer.
#include "facet/testing/estimator/estimator_fuzz.h"

#include <gtest/gtest.h>

#include "facet/testing/fuzz_corpus.h"

namespace facet::testing {
namespace {

TEST(EstimatorFuzzTest, SavedInputs) {
  const std::vector<FuzzInput> inputs = SavedFuzzInputs("estimator");
  EXPECT_FALSE(inputs.empty());
  for (std::size_t i = 0; i < inputs.size(); ++i)
    EXPECT_EQ(FuzzEstimator(inputs[i]), "") << "input " << i;
}

TEST(EstimatorFuzzTest, AnyInput) {
  const std::vector<FuzzInput> seeds = EstimatorFuzzSeeds();
  Rng rng(1);
  const int num_runs = NumFuzzRuns(1500);
  for (int run = 0; run < num_runs; ++run) {
    FuzzInput input = Damaged(seeds[static_cast<std::size_t>(run) % seeds.size()], rng);
    if (run % 4 == 0) input = Damaged(input, rng);
    EXPECT_EQ(FuzzEstimator(input), "") << "run " << run << ": " << ToHex(input);
  }
}

}  // namespace
}  // namespace facet::testing
