// SPDX-License-Identifier: BSD-2-Clause
// IMU streams under libFuzzer (clang and FACET_FUZZER=ON; scripts/test_long.sh).
#include "facet/testing/fuzz_corpus.h"
#include "facet/testing/imu/imu_fuzz.h"

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerInitialize(int* num_arguments, char*** arguments) {
  std::vector<facet::testing::FuzzInput> inputs = facet::testing::SavedFuzzInputs("imu");
  for (const facet::testing::FuzzInput& seed : facet::testing::ImuFuzzSeeds())
    inputs.push_back(seed);
  facet::testing::WriteSeedsIfAsked(*num_arguments, *arguments, inputs);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  facet::testing::AbortOnProblem(facet::testing::FuzzImu({data, size}));
  return 0;
}
