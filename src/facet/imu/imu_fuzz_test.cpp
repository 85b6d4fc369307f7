// SPDX-License-Identifier: BSD-2-Clause
// IMU streams of any content keep what the buffer and the integration promise. FACET_FUZZ_RUNS sets
// how many; `make test-long` runs the same under libFuzzer.
#include "facet/testing/imu/imu_fuzz.h"

#include <gtest/gtest.h>

#include "facet/testing/fuzz_corpus.h"

namespace facet::testing {
namespace {

TEST(ImuFuzzTest, SavedInputs) {
  const std::vector<FuzzInput> inputs = SavedFuzzInputs("imu");
  EXPECT_FALSE(inputs.empty());
  for (std::size_t i = 0; i < inputs.size(); ++i)
    EXPECT_EQ(FuzzImu(inputs[i]), "") << "input " << i;
}

TEST(ImuFuzzTest, AnyStream) {
  const std::vector<FuzzInput> seeds = ImuFuzzSeeds();
  Rng rng(1);
  const int num_runs = NumFuzzRuns(50000);
  for (int run = 0; run < num_runs; ++run) {
    FuzzInput input = Damaged(seeds[static_cast<std::size_t>(run) % seeds.size()], rng);
    if (run % 4 == 0) input = Damaged(input, rng);
    EXPECT_EQ(FuzzImu(input), "") << "run " << run << ": " << ToHex(input);
  }
}

}  // namespace
}  // namespace facet::testing
